"""Stamps: what an installed or built tree was made from, so that a set-up that is current costs only this check."""

import hashlib
import sys
from collections.abc import Iterable
from pathlib import Path

BUILD_FILES = ("package.xml", "setup.py", "setup.cfg", "CMakeLists.txt", "cmake/*.cmake", "msg/*", "srv/*", "action/*")
DATA_FILES = ("launch/*", "config/*", "rviz/*", "worlds/*")


def digest(parts: Iterable[bytes]) -> str:
    """Return one SHA-256 over parts, each delimited."""
    total = hashlib.sha256()
    for part in parts:
        total.update(hashlib.sha256(part).digest())
    return total.hexdigest()


def machine_part(root: Path, ros: Path | None) -> bytes:
    """Return what both stamps depend on besides files: the place of the tree, the Python and the ROS."""
    return repr((str(root), sys.version_info[:3], str(ros))).encode()


def locked(lock: Path) -> bytes:
    """Return what a lock file names; its comments change nothing that is installed."""
    return b"".join(line for line in lock.read_bytes().splitlines(keepends=True) if not line.startswith(b"#"))


def installed_stamp(root: Path, ros: Path | None, lock: Path) -> str:
    """Return the stamp of a virtual environment made from `lock`."""
    return digest([machine_part(root, ros), locked(lock)])


def built_stamp(root: Path, ros: Path | None, packages: Iterable[Path], lock: Path) -> str:
    """Return the stamp of a workspace: the manifests' contents, and the names of data files, which are linked."""
    parts = [machine_part(root, ros), locked(lock)]
    for package in sorted(packages):
        for pattern in BUILD_FILES:
            for path in sorted(package.glob(pattern)):
                parts += [str(path.relative_to(root)).encode(), path.read_bytes()]
        parts += [str(path.relative_to(root)).encode() for p in DATA_FILES for path in sorted(package.glob(p))]
    return digest(parts)


def read(path: Path) -> str | None:
    """Return a stamp that was written, or None where there is none."""
    return path.read_text() if path.exists() else None


def write(path: Path, stamp: str) -> None:
    """Write a stamp in one step, so that an interruption leaves either none or a whole one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_suffix(".half")
    half.write_text(stamp)
    half.replace(path)
