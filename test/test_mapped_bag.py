"""`hslam map`: a bag of odometry and scans alone becomes an atlas and a path, whoever drove."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from whole_runs import hslam, outcome

from hslam_atlas.store import AtlasStore
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the bag of a lidar robot that explores; what the levels said in it is not read."""
    out = tmp_path_factory.mktemp("driven") / "run"
    arguments = ("explore", "small_world", "--robot", "turtlebot", "--landmarks", "scan", "--in-process", "--seed", "1")
    status, _, err = outcome(hslam(*arguments, "--out", str(out)))
    assert status == 0, err
    return out / "bag"


def truth(bag: Path) -> dict[int, SE2]:
    """Return the true poses by stamp (ns)."""
    poses = {}
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages([c for c in reader.connections if c.topic == "/ground_truth"]):
            msg: Any = reader.deserialize(raw, connection.msgtype)
            place, turn = msg.pose.pose.position, msg.pose.pose.orientation
            stamp_ns = msg.header.stamp.sec * 10**9 + msg.header.stamp.nanosec
            poses[stamp_ns] = SE2(place.x, place.y, 2.0 * math.atan2(turn.z, turn.w))
    return poses


@pytest.mark.slow
def test_a_recorded_drive_becomes_an_atlas_and_a_path_that_closes(bag: Path, tmp_path: Path) -> None:
    status, said, err = outcome(hslam("map", str(bag), "--out", str(tmp_path / "map"), "--json"))
    assert status == 0, err
    report = json.loads(said)
    assert (report["nodes"], report["edges"], report["parts"], report["losses"]) == (3, 3, 1, 0)
    assert report["closures"] >= 1
    with AtlasStore.reading(tmp_path / "map" / "atlas.db") as store:
        graph, questions = store.load()
    assert questions == []
    kinds = sorted(node.kind.name for node in graph.nodes.values())
    assert kinds == [NodeKind.BOUNDARY_POINT.name, NodeKind.MEET_POINT.name, NodeKind.MEET_POINT.name]
    assert (tmp_path / "map" / "atlas.svg").stat().st_size > 5_000

    true = truth(bag)
    path = np.loadtxt(tmp_path / "map" / "path.tum")
    stamps = [min(true, key=lambda stamp: abs(stamp - 1e9 * seconds)) for seconds in path[::20, 0]]
    found = [SE2(row[1], row[2], 2.0 * math.atan2(row[6], row[7])) for row in path[::20]]
    assert len(found) > 50
    errors = [
        found[0].to(pose).inverse() @ true[stamps[0]].to(true[stamp]) for pose, stamp in zip(found, stamps, strict=True)
    ]
    assert max(math.hypot(error.x, error.y) for error in errors) < 0.3
    assert max(abs(math.remainder(error.theta, math.tau)) for error in errors) < 0.06


@pytest.mark.slow
def test_what_cannot_be_mapped_is_one_line(bag: Path, tmp_path: Path) -> None:
    for arguments, problem in (
        ((str(bag), "--scan", "/laser"), "topic /laser: is not in the bag; it has /"),
        ((str(bag), "--set", "gvg.drive=laws"), "drive"),
        ((str(bag), "--set", "gvg.drive=laws"), "--set gvg.drive: here the GVG level watches"),
        ((str(bag), "--set", "gvg.map.cell_m=9"), "map.cell_m"),
        ((str(tmp_path / "none"),), "none"),
    ):
        status, _, err = outcome(hslam("map", *arguments, "--out", str(tmp_path / "map")))
        assert status == 1
        assert problem in err
        assert err.count("\n") == 1
