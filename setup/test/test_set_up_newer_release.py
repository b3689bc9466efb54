"""A set-up installs what is locked, whatever is released later: by the oldest pip that is supported and the newest."""

import os
import subprocess
import sys
import venv
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pip_install
import pytest
from commands import Commands
from machine import SetUpError
from made_up_wheels import lock_line, write_source, write_wheel

REQUIREMENTS = Path(pip_install.__file__).parent.parent / "requirements"
BACKEND = """
import made_up_wheels, pathlib, wanted
assert wanted.version == "1.0", f"built with what was released today: {wanted.version}"
def build_wheel(folder, *_):
    return made_up_wheels.write_wheel(pathlib.Path(folder), "built", "1.0").name
"""


@dataclass(frozen=True)
class Bare:
    """An empty virtual environment with one pip, and a registry it can reach: a folder."""

    python: Path
    pip: tuple[int, ...]
    registry: Path
    environment: dict[str, str]
    commands: Commands

    def lock(self, name: str, *paths: Path) -> Path:
        path = self.registry.parent / name
        path.write_text("".join(lock_line(path) for path in paths))
        return path

    def version(self, module: str) -> str:
        command = [str(self.python), "-c", f"import {module}; print({module}.version)"]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture(scope="module", params=["pip-oldest.lock", "pip-newest.lock"])
def pip(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder with a pip unpacked; it is fetched once and kept in pytest's cache."""
    folder: Path = request.config.cache.mkdir(request.param)
    download = ["download", "--quiet", "--no-deps", "--require-hashes", "--only-binary", ":all:"]
    command = [sys.executable, "-m", "pip", *download, "-d", str(folder), "-r", str(REQUIREMENTS / request.param)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, f"{request.param} could not be fetched: {answer.stderr[-500:]}"
    [path] = folder.glob("pip-*.whl")
    unpacked = tmp_path_factory.mktemp("pip") / path.name.split("-")[1]
    with zipfile.ZipFile(path) as wheel:
        wheel.extractall(unpacked)
    return unpacked


@pytest.fixture
def bare(pip: Path, tmp_path: Path) -> Bare:
    venv.create(tmp_path / "venv", with_pip=False, symlinks=True)
    registry = tmp_path / "registry"
    registry.mkdir()
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PIP_", "PYTHON"))}
    alone = {
        "PIP_CONFIG_FILE": os.devnull,
        "PIP_NO_INDEX": "1",
        "PIP_FIND_LINKS": str(registry),
        "PYTHONPATH": str(pip),
    }
    version = tuple(int(part) for part in pip.name.split("."))
    return Bare(
        tmp_path / "venv" / "bin" / "python", version, registry, kept | alone, Commands(tmp_path / "log", tmp_path)
    )


@pytest.fixture
def locks(bare: Bare) -> tuple[Path, Path]:
    """Return two locks as the suite's: what builds, then the rest; each names a release that has a newer one."""
    wanted, _ = (write_wheel(bare.registry, "wanted", version, "Provides-Extra: more\n") for version in ("1.0", "2.0"))
    asking, _ = (
        write_wheel(bare.registry, "asking", version, "Requires-Dist: wanted[more]>=1.0\n")
        for version in ("1.0", "1.1")
    )
    build = {
        "pyproject.toml": '[build-system]\nrequires = ["wanted"]\nbuild-backend = "backend"\nbackend-path = ["."]\n',
        "backend.py": BACKEND,
        "made_up_wheels.py": Path(__file__).with_name("made_up_wheels.py").read_text(),
    }
    built = write_source(bare.registry, "built", "1.0", build)
    return bare.lock("first.lock", wanted), bare.lock("all.lock", asking, built, wanted)


def test_no_newer_release_is_installed_or_even_minded(bare: Bare, locks: tuple[Path, Path]) -> None:
    for lock in locks:
        pip_install.install(bare.commands, bare.python, lock, bare.environment)
    pip_install.check(bare.python, locks[-1], bare.environment)
    assert [bare.version(module) for module in ("wanted", "asking", "built")] == ["1.0", "1.0", "1.0"]
    # What a person reads meanwhile is told from what this pip prints.
    printed = (bare.registry.parent / "log").read_text().rpartition("==> ")[2]
    fetching, _, _ = printed.partition("Installing collected packages")
    [site] = bare.python.parent.parent.glob("lib/python*/site-packages")
    assert pip_install._stand(fetching, 3, site).text == "fetched 3 of 3 packages, 0 MB"
    assert pip_install._stand(printed, 3, site).share == 1.0


@pytest.mark.parametrize(
    ("left_out", "what", "last_words"),
    [
        ("--no-deps", ("asking", "wanted"), "all requirements must have their versions pinned"),
        ("--no-build-isolation", ("built",), "built with what was released today: 2.0"),
    ],
)
@pytest.mark.usefixtures("locks")
def test_without_either_option_a_newer_release_stops_it(
    bare: Bare,
    left_out: str,
    what: tuple[str, ...],
    last_words: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if left_out == "--no-deps" and bare.pip >= (24,):
        pytest.skip(f"pip {bare.pip} looks for a requirement with an extra in the lock")
    lock = bare.lock("some.lock", *(next(bare.registry.glob(f"{name}-1.0*")) for name in what))
    monkeypatch.setattr(pip_install, "EXACTLY", tuple(o for o in pip_install.EXACTLY if o != left_out))
    with pytest.raises(SetUpError, match=r"installing some.lock failed; the whole output is in .*log"):
        pip_install.install(bare.commands, bare.python, lock, bare.environment)
    assert last_words in capsys.readouterr().err


@pytest.mark.usefixtures("locks")
def test_a_lock_that_leaves_something_out_is_named(bare: Bare) -> None:
    lock = bare.lock("short.lock", bare.registry / "asking-1.0-py3-none-any.whl")
    pip_install.install(bare.commands, bare.python, lock, bare.environment)
    with pytest.raises(SetUpError, match=r"short.lock is not complete: asking 1.0 requires wanted.*not installed"):
        pip_install.check(bare.python, lock, bare.environment)
