"""What the machine itself must have before anything can be installed or built, and which ROS it has."""

import importlib.util
import os
import platform
import shutil
import sys
import sysconfig
from pathlib import Path


class SetUpError(Exception):
    """The set-up cannot go on; the message is one line that says what to do."""


def ros_root() -> Path | None:
    """Return the root of an apt-installed ROS 2 Jazzy (`HSLAM_ROS`, else /opt/ros/jazzy), or None without one."""
    root = Path(os.environ.get("HSLAM_ROS", "/opt/ros/jazzy"))
    return root if (root / "setup.sh").exists() else None


def compiler_missing() -> bool:
    """Tell whether no C++ compiler is named by CXX or found under the usual names."""
    named = os.environ.get("CXX")
    return not any(shutil.which(name) for name in ([named.split()[0]] if named else ["c++", "g++", "clang++"]))


def missing_packages() -> list[str]:
    """Return the Debian packages that hold what is missing here, in order of need."""
    missing = []
    if importlib.util.find_spec("ensurepip") is None or importlib.util.find_spec("venv") is None:
        missing.append("python3-venv")
    if not (Path(sysconfig.get_paths()["include"]) / "Python.h").exists():
        missing.append("python3-dev")
    if compiler_missing():
        missing.append("g++")
    return missing


def check(root: Path | None) -> None:
    """Raise SetUpError where this machine cannot hold the suite; `root` is that of an apt-installed ROS, if any."""
    if missing := missing_packages():
        what = {"python3-venv": "Python's venv module", "python3-dev": "Python's headers", "g++": "a C++ compiler"}
        names = " and ".join(what[name] for name in missing)
        message = f"missing: {names} (for {sys.executable}); on Debian or Ubuntu: apt install {' '.join(missing)}"
        raise SetUpError(message)
    if root is None and (platform.machine() != "x86_64" or platform.libc_ver()[0] != "glibc"):
        message = (
            "ROS 2 wheels exist for x86_64 Linux with glibc only; here, install ROS 2 Jazzy to /opt/ros/jazzy first"
        )
        raise SetUpError(message)
    if root is not None and not (root / "share" / "rosidl_default_generators").exists():
        message = f"{root} cannot build messages; on Ubuntu: apt install ros-jazzy-ros-base ros-dev-tools"
        raise SetUpError(message)


if __name__ == "__main__":
    try:
        check(ros_root())
    except SetUpError as error:
        sys.exit(f"set-up: {error}")
