"""A robot's file: what it may say, and what is told where it is wrong."""

from pathlib import Path

import pytest
from ament_index_python.packages import get_package_share_directory

from hslam_bringup.errors import RunError
from hslam_bringup.robot_file import read_robot


def test_the_file_to_copy_is_one() -> None:
    robot = read_robot(Path(get_package_share_directory("hslam_bringup")) / "config" / "my_robot.yaml")
    assert robot.topics == {"odom": "/odom", "scan": "/scan", "cmd_vel": "/cmd_vel"}
    assert robot.of("gvg")["source"] == "scan"
    assert robot.of("ekf") == {}


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("gvg: {source: scan", "is not YAML"),
        ("[1, 2]", "must hold 'topics' and nodes"),
        ("gvg: scan", "must hold 'topics' and nodes"),
        ("topics: {laser: /scan}", "not 'laser: /scan'"),
        ("topics: {scan: 3}", "not 'scan: 3'"),
        ("nav: {x: 1}", "'nav' is none of topics, gvg"),
        ("gvg: {source: scan, bodi_m: 0.2}", "gvg has no parameter 'bodi_m'"),
        ("gvg: {source: scan, body_m: -0.2}", "body_m"),
        ("gvg: {source: sonars}", "must be ring or scan"),
        ("atlas: {store: a.db}", "atlas.store is chosen by the command"),
    ],
)
def test_what_is_wrong_is_told_by_file_and_key(tmp_path: Path, text: str, why: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(RunError) as told:
        read_robot(path)
    assert str(path) in str(told.value)
    assert why in str(told.value)


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="cannot read"):
        read_robot(tmp_path / "robot.yaml")
