"""The lock files: each says what for and by what it was made, and `make lock` writes all of them."""

import re
import subprocess
import sys
from pathlib import Path

import pip_install
import pytest
import stamps
import write_locks
from launchers import clean_environment
from machine import ros_root

LOCKS = sorted(write_locks.REQUIREMENTS.glob("*.lock"))


def test_every_lock_file_is_written_by_make_lock() -> None:
    assert {path.stem for path in LOCKS} == set(write_locks.LOCKS)


@pytest.mark.parametrize("path", LOCKS, ids=lambda path: path.name)
def test_a_lock_states_its_tool_and_pythons_and_pins_everything_by_hash(path: Path) -> None:
    first, *lines = path.read_text().splitlines()
    assert first + "\n" == write_locks.head(write_locks.LOCKS[path.stem], write_locks.tool_version())
    entries = re.split(r"^(?=\S)", "\n".join(lines), flags=re.MULTILINE)
    assert all(re.match(r"[\w.-]+==\S+ .*--hash=sha256:", entry, re.DOTALL) for entry in entries if entry)


def test_what_is_installed_here_from_its_lock_is_complete() -> None:
    ros = ros_root()
    lock = write_locks.REQUIREMENTS / ("ros-from-apt.lock" if ros else "ros-from-pip.lock")
    pip_install.check(Path(sys.executable), lock, clean_environment(Path(sys.prefix), ros))


def test_the_locked_pythons_are_those_that_set_up_takes() -> None:
    find_python = Path(write_locks.__file__).with_name("find_python.sh").read_text()
    oldest, newest = (tuple(map(int, version.split("."))) for version in write_locks.PYTHONS)
    assert f"{oldest} <= sys.version_info[:2] <= {newest}" in find_python


def test_make_lock_gives_on_what_it_is_given() -> None:
    command = ["make", "--dry-run", "lock", "LOCK_ARGS=--upgrade-package numpy"]
    said = subprocess.run(command, cwd=write_locks.ROOT, capture_output=True, text=True, check=True).stdout
    assert "write_locks.py --upgrade-package numpy" in said


def test_a_comment_in_a_lock_file_makes_nothing_anew(tmp_path: Path) -> None:
    lock = tmp_path / "a.lock"
    lock.write_text("x==1\n")
    stamp = stamps.installed_stamp(tmp_path, None, lock)
    lock.write_text("# by another tool\nx==1\n")
    assert stamps.installed_stamp(tmp_path, None, lock) == stamp
