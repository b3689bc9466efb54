"""Ctrl-C while an executable still imports: it ends at once, and Python prints no traceback."""

import os
import signal
import subprocess
from importlib.metadata import EntryPoint, distribution
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_prefix
from test_package_borders import PYTHON
from whole_runs import PATIENCE_S

STOP_AT = """
import os, sys

class StopAt:
    def find_spec(self, name, path=None, target=None):
        if name == os.environ["STOP_AT"]:
            print("importing", flush=True)
            sys.stdin.read()

sys.meta_path.insert(0, StopAt())
"""
"""A `sitecustomize` by which Python says that it imports a module, and waits."""

EXECUTABLES = [
    (package, script)
    for package in PYTHON
    for script in distribution(package).entry_points
    if script.group == "console_scripts"
]


def start(package: str, name: str, stop_at: str, folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Start an executable that stops where it imports a module."""
    (folder / "sitecustomize.py").write_text(STOP_AT)
    path = Path(get_package_prefix(package)) / "lib" / package / name
    search = os.pathsep.join((str(folder), os.environ["PYTHONPATH"]))
    return subprocess.Popen(
        [str(path), *arguments],
        env=os.environ | {"PYTHONPATH": search, "STOP_AT": stop_at},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize(("package", "script"), EXECUTABLES, ids=[script.name for _, script in EXECUTABLES])
def test_an_executable_interrupted_while_it_imports_says_nothing(
    package: str, script: EntryPoint, tmp_path: Path
) -> None:
    last = "cli" if script.name == "hslam" else script.name
    process = start(package, script.name, f"{package}.{last}", tmp_path)
    assert process.stdout
    assert process.stdout.readline() == "importing\n"
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=PATIENCE_S)
    assert said == ("", "")
    assert process.returncode == -signal.SIGINT


def test_once_a_command_has_been_imported_it_ends_as_it_sees_fit(tmp_path: Path) -> None:
    """Ctrl-C is an exception again: typer answers it, and what a command has begun is put in order."""
    process = start("hslam_bringup", "hslam", "hslam_sim.truth", tmp_path, "gvg", "small_world")
    assert process.stdout
    assert process.stdout.readline() == "importing\n"
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert "Traceback" not in said
    assert process.returncode in {1, 130}  # 1 by typer 0.9
