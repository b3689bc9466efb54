"""`hslam import carmen`: a public data set becomes a bag of what a robot's drivers would have said."""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from rosbags.highlevel import AnyReader
from typer.testing import CliRunner

from hslam_bringup.cli import app
from hslam_types.errors import HslamError

RANGES = "1.0 2.0 3.0 80.0"


def laser(x: float, time_s: float) -> str:
    return f"FLASER 4 {RANGES} {x + 0.1} 0 0 {x} 0 0 {time_s} host 0"


def imported(tmp_path: Path, *lines: str) -> tuple[dict[str, Any], dict[str, list[Any]]]:
    """Import a log of these lines; return what was reported and the messages by topic."""
    (tmp_path / "a.log").write_text("\n".join(lines) + "\n")
    out = tmp_path / "bag"
    result = CliRunner().invoke(app, ["import", "carmen", str(tmp_path / "a.log"), "--out", str(out), "--json"])
    if result.exception is not None:
        raise result.exception
    heard: dict[str, list[Any]] = {}
    with AnyReader([out]) as reader:
        for connection, stamp_ns, raw in reader.messages():
            message: Any = reader.deserialize(raw, connection.msgtype)
            heard.setdefault(connection.topic, []).append((stamp_ns, message))
    return json.loads(result.stdout), heard


def test_what_the_drivers_would_have_said_is_in_the_bag(tmp_path: Path) -> None:
    report, heard = imported(
        tmp_path, "PARAM a 1", "ODOM 0 0 0 0 0 0 100.0 host 0", laser(0.5, 100.5), laser(1.0, 101.0)
    )
    assert report == {
        "scans": 2, "odometry": 3, "seconds": 1.0, "driven_m": 1.0, "clock_steps_back": 0, "left_out": {"PARAM": 1},
        "scanner_in_base": [pytest.approx(0.1), 0.0, 0.0],
    }  # fmt: skip
    assert {topic: len(messages) for topic, messages in heard.items()} == {
        "/odom": 3, "/tf": 3, "/scan": 2, "/tf_static": 1
    }  # fmt: skip
    _, scan = heard["/scan"][0]
    assert scan.header.stamp.sec == 100
    assert scan.header.stamp.nanosec == 500_000_000
    assert scan.ranges.tolist() == [1.0, 2.0, 3.0, math.inf]
    assert (scan.angle_min, scan.angle_increment) == (pytest.approx(-math.pi / 2), pytest.approx(math.pi / 4))
    mounting = heard["/tf_static"][0][1].transforms[0]
    assert mounting.transform.translation.x == pytest.approx(0.1)
    assert (mounting.header.frame_id, mounting.child_frame_id) == ("base_link", scan.header.frame_id)
    moves = [message.transforms[0].transform.translation.x for _, message in heard["/tf"]]
    assert moves == [odom.pose.pose.position.x for _, odom in heard["/odom"]] == [0.0, 0.5, 1.0]


def test_a_clock_that_steps_back_leaves_the_order_and_is_told(tmp_path: Path) -> None:
    report, heard = imported(tmp_path, laser(0.0, 100.0), laser(0.1, 99.0), laser(0.2, 100.0), laser(0.3, 101.0))
    assert report["clock_steps_back"] == 1
    stamps = [stamp_ns for stamp_ns, _ in heard["/scan"]]
    assert stamps == sorted(set(stamps))
    assert [message.pose.pose.position.x for _, message in heard["/odom"]] == [0.0, 0.1, 0.2, 0.3]


def test_a_log_without_a_scan_is_none(tmp_path: Path) -> None:
    with pytest.raises(HslamError, match="holds no scan"):
        imported(tmp_path, "what is this")


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    imported(tmp_path, laser(0.0, 100.0))
    with pytest.raises(HslamError, match="not empty"):
        imported(tmp_path, laser(0.0, 100.0))
