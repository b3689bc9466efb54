"""A small floor explored, then used: a robot sent about in its atlas, and one that wakes up in it."""

import json
from pathlib import Path

import pytest
from whole_runs import hslam, outcome


@pytest.fixture(scope="module")
def atlas(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("explored")
    status, _, err = outcome(hslam("explore", "small_world", "--in-process", "--out", str(out)))
    assert status == 0, err
    return out / "atlas.db"


@pytest.mark.slow
def test_random_places_are_reached(atlas: Path) -> None:
    before = atlas.read_bytes()
    arguments = ("navigate", str(atlas), "--world", "small_world", "--goals", "3", "--json")
    status, out, err = outcome(hslam(*arguments))
    assert status == 0, err
    found = json.loads(out)
    assert list(found) == ["goals", "reached", "error_m_max", "driven_over_shortest"]
    assert found["goals"] == found["reached"] == 3
    assert 0.0 < found["error_m_max"] < 0.2
    assert 0.8 < found["driven_over_shortest"] < 5.0
    assert atlas.read_bytes() == before


@pytest.mark.slow
def test_a_robot_that_wakes_up_finds_its_place(atlas: Path) -> None:
    arguments = ("localise", str(atlas), "--world", "small_world", "--starts", "1", "--json")
    status, out, err = outcome(hslam(*arguments))
    assert status == 0, err
    found = json.loads(out)
    assert list(found) == ["starts", "right", "wrong", "driven_m"]
    assert (found["starts"], found["right"], found["wrong"]) == (1, 1, 0)
    assert 5.0 < found["driven_m"] < 100.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("--world", "nowhere"), "no world 'nowhere'"),
        (("--world", "small_world", "--world-seed", "9"), "does not fit the world"),
        (("--world", "small_world", "--robot", "scout"), "use --robot sim"),
    ],
)
def test_what_cannot_be_is_one_line(atlas: Path, arguments: tuple[str, ...], why: str) -> None:
    status, _, err = outcome(hslam("navigate", str(atlas), *arguments))
    line = err.strip().splitlines()[-1]
    assert status == 1
    assert line.startswith("hslam: ")
    assert why in line
