"""A robot that offers nothing but odometry, scans and a base that obeys explores by `hslam drive`."""

import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest
import yaml
from rosbags.highlevel import AnyReader
from whole_runs import hslam, outcome, wait_until

from hslam_atlas.explore import unexplored
from hslam_atlas.store import AtlasStore
from hslam_bringup.fleet import executable

TEE = """
name: tee
start: {x: 3.0, y: 0.0, heading_deg: 0}
corridors:
  - {name: bar, width: 2.0, line: [[0, 0], [12, 0]]}
  - {name: stem, width: 2.0, line: [[6, 0], [6, -6]]}
"""
ROBOT = "topics: {odom: /odom, scan: /scan, cmd_vel: /cmd_vel}\ngvg: {source: scan, cruise_m_s: 0.3}\n"


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Path]:
    """Let a simulated robot with a lidar stand in a corridor; yield its file."""
    (tmp_path / "tee.yaml").write_text(TEE)
    (tmp_path / "robot.yaml").write_text(ROBOT)
    parameters = {
        "world": tmp_path / "tee.yaml", "lockstep": "false", "real_time_factor": 4.0, "lidar.beams": 360, "seed": 1,
    }  # fmt: skip
    given = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    sim = subprocess.Popen([str(executable("hslam_sim", "sim_node")), "--ros-args", *given])
    yield tmp_path / "robot.yaml"
    sim.terminate()
    sim.wait(30.0)


@pytest.mark.slow
def test_a_building_is_explored_by_plain_topics_with_landmarks_from_the_scans(robot: Path) -> None:
    out = robot.parent / "out"
    status, said, err = outcome(hslam("drive", str(robot), "--out", str(out)))
    assert status == 0, err
    assert "4 nodes, 3 edges, 0 branches out of reach" in said
    with AtlasStore.reading(out / "atlas.db") as store:
        graph, questions = store.load()
    assert (len(graph.nodes), len(graph.edges), unexplored(graph), questions) == (4, 3, 0, [])
    assert (out / "atlas.svg").stat().st_size > 5_000


def recorded(bag: Path, topic: str) -> int:
    """Return how many messages of a topic are on disk, of a bag that is being written."""
    metadata = bag / "metadata.yaml"
    if not metadata.exists():
        return 0
    topics = yaml.safe_load(metadata.read_text())["rosbag2_bagfile_information"]["topics_with_message_count"]
    counts = {entry["topic_metadata"]["name"]: entry["message_count"] for entry in topics}
    return int(counts.get(topic, 0))


@pytest.mark.slow
def test_ctrl_c_stops_the_robot_and_keeps_the_bag_whole(robot: Path) -> None:
    out = robot.parent / "out"
    run = hslam("drive", str(robot), "--out", str(out))
    wait_until(lambda: recorded(out / "bag", "/cmd_vel") > 100)
    run.send_signal(signal.SIGINT)
    status, _, err = outcome(run)
    assert status == 130
    assert "interrupted, the robot is stopped" in err
    with AnyReader([out / "bag"]) as reader:
        commands = [
            cast(Any, reader.deserialize(raw, connection.msgtype)).twist
            for connection, _, raw in reader.messages([c for c in reader.connections if c.topic == "/cmd_vel"])
        ]
    assert any(command.linear.x > 0.05 for command in commands)
    assert (commands[-1].linear.x, commands[-1].angular.z) == (0.0, 0.0)
