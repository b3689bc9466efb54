"""Installs what a lock file names, and nothing else: no release of anything, ever, changes what is installed."""

import re
import subprocess
from collections.abc import Mapping
from pathlib import Path

from commands import Commands, Stand
from machine import SetUpError

EXACTLY = ("--no-deps", "--require-hashes", "--no-build-isolation", "--use-pep517")
"""Resolve nothing: a pip before 24 looks for a requirement with an extra by itself, and stops where there is a newer
release than the locked one. Build sources with what is locked, too."""

QUIETLY = ("--no-input", "--no-compile", "--disable-pip-version-check", "--progress-bar", "off")

_FETCHED = re.compile(r"^(?:Collecting|Processing|Requirement already satisfied:) ", re.MULTILINE)
_ELSEWHERE = re.compile(r"^Ignoring .*: markers ", re.MULTILINE)
_SIZE = re.compile(r"^ *Downloading .*\((\d+(?:\.\d+)?) ([kM])B\)$", re.MULTILINE)
_MB = {"k": 1e-3, "M": 1.0}


def install(
    commands: Commands, python: Path, lock: Path, environment: Mapping[str, str], target: Path | None = None
) -> None:
    """Install a lock file by the pip of ``python``, into ``target`` if given; raises SetUpError where that fails."""
    pip = [str(python), "-m", "pip", "install", *QUIETLY, *EXACTLY, "-r", str(lock)]
    pip += ["--target", str(target)] if target else []
    [site] = [target] if target else (python.parent.parent / "lib").glob("python*/site-packages")
    locked = len(re.findall(r"^\S+==", lock.read_text(), re.MULTILINE))
    commands.run(pip, environment, f"installing {lock.name}", lambda printed: _stand(printed, locked, site))


def check(python: Path, lock: Path, environment: Mapping[str, str]) -> None:
    """Raise SetUpError where something that was installed lacks what it requires."""
    command = [str(python), "-m", "pip", "check", "--disable-pip-version-check"]
    answer = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if answer.returncode:
        found = "; ".join((answer.stdout or answer.stderr).strip().splitlines())
        raise SetUpError(f"{lock.name} is not complete: {found}; after a change of requirements/*.in: make lock")


def _stand(printed: str, locked: int, site: Path) -> Stand:
    """Tell how far pip is: half of the work is to fetch, half to unpack.

    ``locked`` counts what the lock names for any Python; ``site`` is the folder that pip unpacks into.
    """
    total = max(1, locked - len(_ELSEWHERE.findall(printed)))
    fetched = min(total, len(_FETCHED.findall(printed)))
    size_mb = sum(float(number) * _MB[unit] for number, unit in _SIZE.findall(printed))
    if "\nInstalling collected packages" not in printed:
        return Stand(fetched / total / 2, f"fetched {fetched} of {total} packages, {size_mb:.0f} MB")
    unpacked = min(total, len(list(site.glob("*.dist-info"))))
    return Stand((total + unpacked) / total / 2, f"unpacked {unpacked} of {total} packages")
