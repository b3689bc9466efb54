"""Sets the suite up: a virtual environment from a lock file, the workspace built by colcon, and the launchers.

Run by `make setup`. It does only what is not yet done or no longer current, and may be interrupted at any point.
"""

import fcntl
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from launchers import clean_environment, sourced, write_launchers
from machine import SetUpError, check, ros_root
from stamps import built_stamp, installed_stamp, read, write

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
INSTALLED = VENV / "hslam-installed.stamp"
BUILT = ROOT / "install" / "hslam-built.stamp"
STARTED = ROOT / "build" / "hslam-started.stamp"
FROM_PIP = ROOT / "setup" / "from_pip" / "tf2_msgs"


class CutShortError(SetUpError):
    """A command of the set-up was ended by a signal: what it was writing may be half written."""


def say(text: str) -> None:
    """Tell the person at the terminal what goes on."""
    sys.stdout.write(f"set-up: {text}\n")
    sys.stdout.flush()


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


def run(command: list[str], environment: dict[str, str], what: str, log: Path | None = None) -> None:
    """Run a command of the set-up, its output to `log` if given; raises SetUpError with the log's place if it fails."""
    if log is None:
        status = subprocess.run(command, env=environment, cwd=ROOT, check=False).returncode
    else:
        log.parent.mkdir(exist_ok=True)
        with log.open("w") as out:
            status = subprocess.run(
                command, env=environment, cwd=ROOT, check=False, stdout=out, stderr=subprocess.STDOUT
            ).returncode
        if status:
            sys.stderr.write("".join(log.read_text(errors="replace").splitlines(keepends=True)[-40:]))
    where = f"; the whole output is in {log}" if log else ""
    if status < 0:
        message = f"{what} was ended by {signal.Signals(-status).name}{where}"
        raise CutShortError(message)
    if status:
        message = f"{what} failed{where}"
        raise SetUpError(message)


def forget_build() -> None:
    """Remove what colcon built: it is half written, or full of paths into a virtual environment that is gone."""
    for folder in (ROOT / "build", ROOT / "install"):
        shutil.rmtree(folder, ignore_errors=True)


def install(ros: Path | None, lock: Path) -> None:
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
    run([sys.executable, "-m", "venv", str(VENV)], clean_environment(VENV, ros), "making .venv")
    say(f"installing {lock.relative_to(ROOT)} into .venv; this takes a minute or two")
    pip = [str(VENV / "bin" / "python"), "-m", "pip", "install", "--quiet", "--no-input", "--no-compile"]
    pip += ["--disable-pip-version-check", "--no-build-isolation", "--use-pep517", "--no-deps", "--require-hashes"]
    for locked in (lock.with_name("setuptools.lock"), lock):
        run([*pip, "-r", str(locked)], clean_environment(VENV, ros), f"installing {locked.name}")
    # pip compiles on one core; this uses all.
    compiling = [str(VENV / "bin" / "python"), "-m", "compileall", "-q", "-j", "0", str(VENV / "lib")]
    subprocess.run(compiling, env=clean_environment(VENV, ros), check=False, stdout=subprocess.DEVNULL)
    write(INSTALLED, stamp)


def build(ros: Path | None, lock: Path) -> None:
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
    say("building the workspace; the first time this takes two or three minutes")
    environment = clean_environment(VENV, ros)
    if ros:
        environment = sourced(f". '{ros}/setup.sh'", environment)
    else:
        environment["CMAKE_GENERATOR"] = "Ninja"
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF", f"-DPython3_EXECUTABLE={VENV}/bin/python"]
    colcon = [str(VENV / "bin" / "python"), "-m", "colcon", "build", "--symlink-install", "--base-paths", str(ROOT)]
    colcon += [] if ros else [str(FROM_PIP)]
    try:
        run([*colcon, "--cmake-args", *options], environment, "building the workspace", ROOT / "log" / "set-up.log")
    except CutShortError:
        raise
    except SetUpError:
        STARTED.unlink()  # What is built stays good, unlike after being cut short.
        raise
    write_launchers(ROOT, VENV, ros)
    write(BUILT, stamp)


def main() -> int:
    """Set up what is not current; returns the exit status."""
    started = time.monotonic()
    ros = ros_root()
    lock = ROOT / "requirements" / ("ros-from-apt.lock" if ros else "ros-from-pip.lock")
    try:
        with alone():
            install(ros, lock)
            build(ros, lock)
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
