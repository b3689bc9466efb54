"""Installs the oldest libraries that the suite runs with, for the tests to run with; run by `make oldest`."""

import os
import shutil
import sys
from pathlib import Path

import pip_install
from commands import Commands
from machine import SetUpError
from stamps import installed_stamp, read, write

ROOT = Path(__file__).resolve().parent.parent
LOCK = ROOT / "requirements" / "ubuntu-24.04.lock"
OLDEST = ROOT / ".oldest"
INSTALLED = OLDEST / "hslam-installed.stamp"


def install_oldest(commands: Commands) -> None:
    """Make `.oldest` hold what the lock file names; raises SetUpError where that fails."""
    stamp = installed_stamp(ROOT, None, LOCK)
    if read(INSTALLED) != stamp:
        shutil.rmtree(OLDEST, ignore_errors=True)
        pip_install.install(commands, Path(sys.executable), LOCK, os.environ, target=OLDEST)
        write(INSTALLED, stamp)


if __name__ == "__main__":
    try:
        install_oldest(Commands(ROOT / "log" / "oldest.log", ROOT))
    except SetUpError as error:
        sys.exit(f"make oldest: {error}")
