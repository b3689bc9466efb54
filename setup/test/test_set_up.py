"""The set-up: what it says of a machine that lacks something, and when it takes a tree for current."""

import os
import stat
import subprocess
from pathlib import Path

import launchers
import machine
import pytest
import set_up
import stamps
from commands import Commands
from made_up_wheels import lock_line, write_wheel

SETUP = Path(machine.__file__).parent


def find_python(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    command = ["/bin/sh", str(SETUP / "find_python.sh"), *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def executable(path: Path, text: str) -> Path:
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def test_no_python_is_one_line_that_says_what_to_install(tmp_path: Path) -> None:
    answer = find_python(PATH=str(tmp_path), HSLAM_ROS=str(tmp_path))
    assert answer.returncode == 1
    assert answer.stdout == ""
    assert answer.stderr.count("\n") == 1
    assert "apt install python3" in answer.stderr


def test_a_python_that_does_not_fit_is_passed_over(tmp_path: Path) -> None:
    executable(tmp_path / "python3", "#!/bin/sh\nexit 1\n")
    executable(tmp_path / "python3.12", "#!/bin/sh\necho /it/is/this\n")
    assert find_python(PATH=str(tmp_path), HSLAM_ROS=str(tmp_path)).stdout == "/it/is/this\n"


def test_a_missing_compiler_is_named_with_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CXX", raising=False)
    with pytest.raises(machine.SetUpError, match=r"a C\+\+ compiler.*apt install g\+\+"):
        machine.check(None)
    executable(tmp_path / "g++", "#!/bin/sh\n")
    assert not machine.compiler_missing()


def test_a_ros_without_generators_is_named(tmp_path: Path) -> None:
    with pytest.raises(machine.SetUpError, match="cannot build messages"):
        machine.check(tmp_path)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "some_package"
    (folder / "config").mkdir(parents=True)
    (folder / "config" / "a.yaml").write_text("a: 1\n")
    (folder / "package.xml").write_text("<package/>\n")
    (folder / "node.py").write_text("")
    return folder


def test_the_build_is_keyed_on_manifests_and_on_names_of_linked_files(tmp_path: Path, package: Path) -> None:
    lock = tmp_path / "a.lock"
    lock.write_text("x==1\n")

    def stamp() -> str:
        return stamps.built_stamp(tmp_path, None, [package], lock)

    first = stamp()
    (package / "node.py").write_text("changed = True\n")
    (package / "config" / "a.yaml").write_text("a: 2\n")
    assert stamp() == first, "linked files need no build"
    (package / "config" / "b.yaml").write_text("b: 1\n")
    second = stamp()
    (package / "package.xml").write_text("<package format='3'/>\n")
    third = stamp()
    lock.write_text("x==2\n")
    assert len({first, second, third, stamp()}) == 4


def test_another_python_or_ros_builds_from_the_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lock = tmp_path / "a.lock"
    lock.write_text("x==1\n")
    left = [tmp_path / "build" / "CMakeCache.txt", tmp_path / "install" / "setup.sh"]
    for path in left:
        path.parent.mkdir()
        path.write_text("/of/the/python/before\n")

    class NoNetwork(Commands):
        def run(self, *_: object, **__: object) -> None:
            raise machine.SetUpError("no network")

    commands = NoNetwork(tmp_path / "log", tmp_path)
    monkeypatch.setattr(set_up, "ROOT", tmp_path)
    monkeypatch.setattr(set_up, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(set_up, "INSTALLED", tmp_path / ".venv" / "installed.stamp")
    monkeypatch.setattr(set_up, "check", lambda _: None)
    stamps.write(set_up.INSTALLED, stamps.installed_stamp(tmp_path, None, lock))
    set_up.install(commands, None, lock)
    assert all(path.exists() for path in left), "what is current stays"
    with pytest.raises(machine.SetUpError):
        set_up.install(commands, tmp_path / "another_ros", lock)
    assert not any(path.exists() for path in left)


def test_a_set_up_from_a_lock_that_leaves_something_out_is_not_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asking = write_wheel(tmp_path, "asking", "1.0", "Requires-Dist: wanted\n")
    lock = tmp_path / "a.lock"
    lock.write_text(lock_line(asking))
    (tmp_path / "setuptools.lock").write_text(lock_line(write_wheel(tmp_path, "another", "1.0")))
    installed = tmp_path / ".venv" / "installed.stamp"
    for name, value in {"ROOT": tmp_path, "VENV": tmp_path / ".venv", "INSTALLED": installed}.items():
        monkeypatch.setattr(set_up, name, value)
    monkeypatch.setattr(set_up, "check", lambda _: None)
    for name, text in {"CONFIG_FILE": os.devnull, "NO_INDEX": "1", "FIND_LINKS": str(tmp_path)}.items():
        monkeypatch.setenv(f"PIP_{name}", text)
    with pytest.raises(machine.SetUpError, match=r"a.lock is not complete: asking 1.0 requires wanted.*make lock"):
        set_up.install(Commands(tmp_path / "log", tmp_path), None, lock)
    assert not installed.exists()


def test_a_stamp_is_read_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "some.stamp"
    assert stamps.read(path) is None
    stamps.write(path, "one")
    stamps.write(path, "two")
    assert stamps.read(path) == "two"
    assert [entry.name for entry in path.parent.iterdir()] == ["some.stamp"]


def test_the_launchers_environment_is_that_of_the_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    venv = tmp_path / "a venv"
    (venv / "bin").mkdir(parents=True)
    (tmp_path / "install").mkdir()
    (tmp_path / "install" / "local_setup.sh").write_text('export PYTHONPATH="/some/where:$PYTHONPATH"\n')
    monkeypatch.setenv("PATH", f"{venv / 'bin'}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", "/another/workspace")
    launchers.write_launchers(tmp_path, venv, None)
    command = [str(venv / "bin" / "hslam-env"), "/bin/sh", "-c", 'echo "$PATH|$PYTHONPATH|$AMENT_PREFIX_PATH"']
    outside = {"PATH": "/usr/bin:/bin", "PYTHONPATH": "/another/workspace"}
    said = subprocess.run(command, env=outside, capture_output=True, text=True, check=True).stdout.strip()
    assert said == f"{venv / 'bin'}:/usr/bin:/bin|/some/where|{venv}"
