"""Writes the lock files anew from requirements/*.in, with a tool that is locked itself; run by `make lock`.

What a lock file names already stays at its version where it still fits: to take up newer ones give uv's options, as in
`make lock LOCK_ARGS="--upgrade-package numpy"` or `LOCK_ARGS=--upgrade`.
"""

import os
import shutil
import sys
from pathlib import Path

import pip_install
from commands import Commands, say
from machine import SetUpError

ROOT = Path(__file__).resolve().parent.parent
REQUIREMENTS = ROOT / "requirements"
TOOL = ROOT / ".lock-tool"
TOOL_LOCK = REQUIREMENTS / "lock-tool.lock"
PYTHONS = ("3.11", "3.13")
"""The oldest and the newest Python that is supported."""

LOCKS = {
    "setuptools": ("setuptools",),
    "ros-from-pip": ("ros", "build", "python", "dev"),
    "ros-from-apt": ("build", "python", "dev"),
    "ubuntu-24.04": ("ubuntu-24.04",),
    "pip-oldest": ("pip-oldest",),
    "pip-newest": ("pip-newest",),
    "lock-tool": ("lock-tool",),
}
"""Each lock file, and the lists of requirements that it locks together."""


def tool_version() -> str:
    """Return the locked version of uv."""
    entry = next(line for line in TOOL_LOCK.read_text().splitlines() if line.startswith("uv=="))
    return entry.removeprefix("uv==").split()[0]


def head(lists: tuple[str, ...], version: str) -> str:
    """Return the first line of a lock file: what it is for, from what and by what it was made."""
    names = " ".join(f"{name}.in" for name in lists)
    return f"# For Python {PYTHONS[0]} to {PYTHONS[1]}; written from {names} by 'make lock', with uv {version}.\n"


def write_locks(commands: Commands, options: list[str]) -> None:
    """Write every lock file; raises SetUpError where the tool cannot be installed or finds no answer."""
    shutil.rmtree(TOOL, ignore_errors=True)
    environment = dict(os.environ)
    commands.run([sys.executable, "-m", "venv", str(TOOL)], environment, "making .lock-tool")
    pip_install.install(commands, TOOL / "bin" / "python", TOOL_LOCK, environment)
    version = tool_version()
    compiling = [str(TOOL / "bin" / "uv"), "pip", "compile", "--quiet", "--universal", "--python-version", PYTHONS[0]]
    compiling += ["--generate-hashes", "--no-emit-index-url", "--no-annotate", "--no-header", *options]
    for name, lists in LOCKS.items():
        lock = REQUIREMENTS / f"{name}.lock"
        commands.run(
            [*compiling, *(str(REQUIREMENTS / f"{part}.in") for part in lists), "-o", str(lock)],
            environment,
            f"locking {name}",
        )
        lock.write_text(head(lists, version) + lock.read_text())
        say(f"wrote {lock.relative_to(ROOT)}")


if __name__ == "__main__":
    try:
        write_locks(Commands(ROOT / "log" / "lock.log", ROOT), sys.argv[1:])
    except SetUpError as error:
        sys.exit(f"make lock: {error}")
