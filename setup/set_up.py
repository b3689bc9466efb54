"""Sets the suite up: a virtual environment from a lock file, the workspace built by colcon, and the launchers.

Run by `make setup`. It does only what is not yet done or no longer current, and may be interrupted at any point.
"""

import fcntl
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pip_install
from commands import Commands, CutShortError, Stand, say
from launchers import clean_environment, sourced, write_launchers
from machine import SetUpError, check, ros_root
from stamps import built_stamp, installed_stamp, read, write

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
INSTALLED = VENV / "hslam-installed.stamp"
BUILT = ROOT / "install" / "hslam-built.stamp"
STARTED = ROOT / "build" / "hslam-started.stamp"
LOG = ROOT / "log" / "set-up.log"
FROM_PIP = ROOT / "setup" / "from_pip" / "tf2_msgs"


@contextmanager
def alone() -> Iterator[None]:
    """Hold the tree's lock, so that two set-ups of one tree run after each other."""
    with (ROOT / ".venv.lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("another set-up of this tree is running; waiting for it")
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def forget_build() -> None:
    """Remove what colcon built: it is half written, or full of paths into a virtual environment that is gone."""
    for folder in (ROOT / "build", ROOT / "install"):
        shutil.rmtree(folder, ignore_errors=True)


def install(commands: Commands, ros: Path | None, lock: Path) -> None:
    """Make the virtual environment hold exactly what the lock file names."""
    stamp = installed_stamp(ROOT, ros, lock)
    if read(INSTALLED) == stamp:
        return
    check(ros)
    forget_build()
    if VENV.exists():
        # What an interrupted or older installation left cannot be told from what belongs here.
        say("making the virtual environment anew: the one here is unfinished or of another lock file")
        shutil.rmtree(VENV)
    environment = clean_environment(VENV, ros)
    python = VENV / "bin" / "python"
    commands.run([sys.executable, "-m", "venv", str(VENV)], environment, "making .venv")
    for locked in (lock.with_name("setuptools.lock"), lock):
        pip_install.install(commands, python, locked, environment)
    pip_install.check(python, lock, environment)
    say("compiling what was installed")  # pip would on one core; this uses all
    compiling = [str(python), "-m", "compileall", "-q", "-j", "0", str(VENV / "lib")]
    subprocess.run(compiling, env=environment, check=False, stdout=subprocess.DEVNULL)
    write(INSTALLED, stamp)


def build(commands: Commands, ros: Path | None, lock: Path) -> None:
    """Build the workspace and write the launchers."""
    packages = [path.parent for path in ROOT.glob("*/package.xml")] + ([] if ros else [FROM_PIP])
    stamp = built_stamp(ROOT, ros, packages, lock)
    launchers = [VENV / "bin" / name for name in ("hslam", "hslam-env")]
    if read(BUILT) == stamp and STARTED.exists() and all(path.exists() for path in launchers):
        return
    check(ros)
    if STARTED.exists() and not BUILT.exists():
        say("building from the start: the last build was interrupted")
        forget_build()
    BUILT.unlink(missing_ok=True)
    write(STARTED, stamp)
    environment = clean_environment(VENV, ros)
    if ros:
        environment = sourced(f". '{ros}/setup.sh'", environment)
    else:
        environment["CMAKE_GENERATOR"] = "Ninja"
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF", f"-DPython3_EXECUTABLE={VENV}/bin/python"]
    colcon = [str(VENV / "bin" / "python"), "-m", "colcon", "build", "--symlink-install", "--base-paths", str(ROOT)]
    colcon += [] if ros else [str(FROM_PIP)]
    try:
        commands.run(
            [*colcon, "--cmake-args", *options],
            environment,
            "building the workspace",
            lambda printed: built(printed, len(packages)),
        )
    except CutShortError:
        raise
    except SetUpError:
        STARTED.unlink()  # What is built stays good, unlike after being cut short.
        raise
    write_launchers(ROOT, VENV, ros)
    write(BUILT, stamp)


def built(printed: str, total: int) -> Stand:
    """Tell from what colcon has printed how far it is."""
    begun, ended = (re.findall(rf"^{word} (\w+)", printed, re.MULTILINE) for word in ("Starting >>>", "Finished <<<"))
    now = ", ".join(name for name in begun if name not in ended)
    return Stand(len(ended) / total, f"{len(ended)} of {total} packages" + (f", now {now}" if now else ""))


def main() -> int:
    """Set up what is not current; returns the exit status."""
    started = time.monotonic()
    ros = ros_root()
    lock = ROOT / "requirements" / ("ros-from-apt.lock" if ros else "ros-from-pip.lock")
    commands = Commands(LOG, ROOT)
    try:
        with alone():
            install(commands, ros, lock)
            build(commands, ros, lock)
    except SetUpError as error:
        sys.stderr.write(f"set-up: {error}\n")
        return 1
    except KeyboardInterrupt:
        sys.stderr.write("set-up: interrupted; run it again to go on\n")
        return 130
    if (seconds := time.monotonic() - started) > 1.0:
        say(f"done in {seconds:.0f} s; the command is {os.path.relpath(VENV / 'bin' / 'hslam')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
