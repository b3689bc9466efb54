"""What a person may ask of a run, and that making room for it costs nothing else."""

from pathlib import Path

import pytest

from hslam_bringup.errors import RunError
from hslam_bringup.run_options import (
    ATLAS_FILES,
    SCANNED,
    RunOptions,
    check_landmarks,
    make_output,
    parse_settings,
    prepare_output,
    robot_settings,
)


def test_settings_are_yaml_by_node() -> None:
    given = ["ekf.accept_gate=9", "sim.sonar.noise_fraction=1e-3", "ekf.other=[1, 2]"]
    settings = parse_settings(given, ("sim", "ekf"))
    assert settings == {"ekf": {"accept_gate": 9, "other": [1, 2]}, "sim": {"sonar.noise_fraction": 0.001}}


@pytest.mark.parametrize(
    ("assignment", "told"),
    [
        ("nonsense", "NODE.PARAMETER=VALUE"),
        ("ekf=3", "NODE.PARAMETER=VALUE"),
        ("scout.watchdog_s=1.0", "one of sim, ekf"),
        ("sim.seed=2", "'seed' is not a setting"),
        ("ekf.accept_gate=[", "not YAML"),
        ("ekf.accept_gate=" + "9" * 5000, "the value is not YAML"),
        ("ekf.accept_gate=" + "[" * 5000, "nested too deeply"),
        ("ekf.accept_gate={a: 1, a: 2}", "'a' is there twice"),
    ],
)
def test_a_setting_that_would_do_nothing_or_harm_is_refused(assignment: str, told: str) -> None:
    with pytest.raises(RunError, match=told.replace(".", r"\.")):
        parse_settings([assignment], ("sim", "ekf"))


@pytest.fixture
def filled(tmp_path: Path) -> Path:
    """Return a folder that holds a run and something else."""
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.mcap").write_bytes(b"recorded")
    (tmp_path / "atlas.db").write_bytes(b"learnt")
    (tmp_path / "scout.tty").symlink_to(tmp_path / "gone")
    (tmp_path / "notes.txt").write_text("mine")
    return tmp_path


def test_an_earlier_run_stays_unless_forced(filled: Path) -> None:
    with pytest.raises(RunError, match="--force"):
        prepare_output(filled, force=False)
    assert (filled / "atlas.db").read_bytes() == b"learnt"


def test_force_removes_what_a_run_leaves_and_nothing_else(filled: Path) -> None:
    prepare_output(filled, force=True)
    assert [path.name for path in filled.iterdir()] == ["notes.txt"]


def test_a_place_for_an_atlas_is_made_and_nothing_removed(filled: Path) -> None:
    with pytest.raises(RunError, match=r"holds a run \(atlas\.db\)"):
        make_output(filled, ATLAS_FILES, force=False)
    assert make_output(filled, ATLAS_FILES, force=True) == [filled / "atlas.db"]
    assert (filled / "atlas.db").read_bytes() == b"learnt"
    assert (filled / "bag" / "bag_0.mcap").read_bytes() == b"recorded"


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="cannot write to"):
        prepare_output(tmp_path / "file" / "run", force=False)


def test_landmarks_by_scans_ask_for_a_lidar(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="--robot turtlebot"):
        check_landmarks(RunOptions("small_world", 1, tmp_path, landmarks=SCANNED))
    with pytest.raises(RunError, match="--robot turtlebot"):
        check_landmarks(RunOptions("small_world", 1, tmp_path, robot="scout", landmarks=SCANNED))
    check_landmarks(RunOptions("small_world", 1, tmp_path, robot_settings("turtlebot"), landmarks=SCANNED))
    check_landmarks(RunOptions("small_world", 1, tmp_path))
