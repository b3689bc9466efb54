"""An exploration broken off is gone on with: the robot finds out where it is, and the graph is the whole one."""

import json
from pathlib import Path

import pytest
from whole_runs import hslam, outcome


def explored(out: Path, *more: str) -> tuple[int, str]:
    """Explore the small floor in one process; return exit status and what stderr said."""
    status, _, err = outcome(hslam("explore", "small_world", "--in-process", "--out", str(out), *more))
    return status, err


@pytest.fixture(scope="module")
def broken_off(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run that ended with a third of the floor left."""
    out = tmp_path_factory.mktemp("runs") / "first"
    status, err = explored(out, "--time-limit", "180")
    assert status == 1
    assert "not finished after 180 simulated seconds" in err
    assert not json.loads((out / "report.json").read_text())["completed"]
    return out


def test_what_was_broken_off_is_completed_and_scored_as_one(broken_off: Path) -> None:
    out = broken_off.parent / "second"
    status, err = explored(out, "--resume", str(broken_off))
    assert status == 0, err
    before, report = (json.loads((run / "report.json").read_text()) for run in (broken_off, out))
    assert report["completed"]
    assert report["isomorphic"]
    assert report["loop_closures_false"] == report["collisions"] == 0
    assert report["path_length_m"] > before["path_length_m"] + 10.0
    assert report["landmark_rmse_edge_m"] < 0.1


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (("--seed", "2"), "explored small_world with --seed 1: resume it with these"),
        (("--robot", "scout"), "the Scout's emulator begins at the floor's start"),
    ],
)
def test_another_floor_or_a_base_that_cannot_be_put_there_is_refused(
    broken_off: Path, more: tuple[str, ...], why: str
) -> None:
    arguments = ("explore", "small_world", "--out", str(broken_off.parent / "third"), "--resume", str(broken_off))
    status, _, err = outcome(hslam(*arguments, *more))
    assert status == 1
    assert why in err
    assert len(err.splitlines()) == 1


def test_a_run_is_not_resumed_into_its_own_folder(broken_off: Path) -> None:
    status, err = explored(broken_off, "--force", "--resume", str(broken_off))
    assert status == 1
    assert "is --out itself" in err
    assert (broken_off / "atlas.db").exists()


def test_a_folder_without_a_run_is_told_by_name(tmp_path: Path) -> None:
    status, err = explored(tmp_path / "out", "--resume", str(tmp_path / "nothing"))
    assert status == 1
    assert "nothing" in err
    assert len(err.splitlines()) == 1
