"""Launchers in the virtual environment, which work in a shell that has sourced nothing.

`hslam-env COMMAND...` runs a command in the environment of the workspace, `hslam` runs the suite's own command there.
What sourcing the workspace's set-up files gives is found once, here, because sourcing them costs half a second.
"""

import os
import shlex
import subprocess
from pathlib import Path

KEPT = ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH", "PYTHONPATH", "ROS_DISTRO", "ROS_VERSION")
SYSTEM_PATH = ("/usr/local/bin", "/usr/bin", "/bin")
FOREIGN = (
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "LD_LIBRARY_PATH",
    "PYTHONHOME",
    "PYTHONPATH",
)


def clean_environment(venv: Path, ros: Path | None) -> dict[str, str]:
    """Return this process's environment without any other workspace's or Python's marks, the virtual one first."""
    marks = (*FOREIGN, "_ROS_WHEELS_BOOTSTRAP_COMPLETE", "ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION")
    environment = {name: value for name, value in os.environ.items() if name not in marks}
    environment["PATH"] = f"{venv / 'bin'}{os.pathsep}{environment['PATH']}"
    environment["VIRTUAL_ENV"] = str(venv)
    if ros is None:
        environment["AMENT_PREFIX_PATH"] = environment["CMAKE_PREFIX_PATH"] = str(venv)
    return environment


def sourced(script: str, environment: dict[str, str]) -> dict[str, str]:
    """Return the environment after a shell has run `script` in `environment`."""
    command = ["/bin/sh", "-c", f"{{ {script}; }} >/dev/null && env -0"]
    text = subprocess.run(command, env=environment, check=True, capture_output=True).stdout.decode()
    return dict(line.split("=", 1) for line in text.split("\0") if "=" in line)


def environment_lines(sourced_here: dict[str, str], root: Path) -> list[str]:
    """Return the shell lines that bring any environment to the sourced one; PATH is extended, the rest replaced."""
    lines = []
    for name in KEPT:
        entries = [entry for entry in sourced_here.get(name, "").split(os.pathsep) if entry]
        if entries:
            lines.append(f"export {name}={shlex.quote(os.pathsep.join(entries))}")
    added = [entry for entry in sourced_here["PATH"].split(os.pathsep) if entry not in SYSTEM_PATH]
    lines.append(f'export PATH={shlex.quote(os.pathsep.join(added))}{os.pathsep}"$PATH"')
    # More threads would change the order of sums, and with it the last bits of a result.
    lines.append("export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1")
    lines.append("unset PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE")
    lines.append(f'[ -n "$HOME$ROS_LOG_DIR" ] || export ROS_LOG_DIR={shlex.quote(str(root / "log"))}')
    return lines


def write_launchers(root: Path, venv: Path, ros: Path | None) -> None:
    """Write `hslam-env` and `hslam` for the workspace built in `root`."""
    start = clean_environment(venv, ros)
    # Not this shell's PATH: what it already holds would not be seen to be added.
    start["PATH"] = os.pathsep.join([str(venv / "bin"), *SYSTEM_PATH])
    scripts = [f". {shlex.quote(str(ros / 'setup.sh'))}"] if ros else []
    scripts.append(f". {shlex.quote(str(root / 'install' / 'local_setup.sh'))}")
    lines = environment_lines(sourced("; ".join(scripts), start), root)
    head = "#!/bin/sh\n# Written by make setup; do not edit.\n" + "\n".join(lines) + "\n"
    command = shlex.quote(str(root / "install" / "hslam_bringup" / "lib" / "hslam_bringup" / "hslam"))
    for name, last in {"hslam-env": 'exec "$@"', "hslam": f'exec {command} "$@"'}.items():
        path = venv / "bin" / name
        path.write_text(f"{head}{last}\n")
        path.chmod(0o755)
