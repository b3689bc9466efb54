"""What a run recorded makes its atlas again: in one process, through the nodes, with other parameters."""

import math
import os
import signal
import sqlite3
import subprocess
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from hslam_msgs.msg import Atlas
from rclpy.serialization import deserialize_message
from whole_runs import atlas_dump, hslam, outcome

from hslam_atlas.atlas_messages import atlas_to_msg
from hslam_atlas.picture import node_poses
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_bags.bag import Bag
from hslam_bags.errors import BagError
from hslam_bags.repair import copy
from hslam_bags.topic_choice import TopicChoice
from hslam_bringup.bag_loop import rebuild_atlas
from hslam_bringup.fleet import executable
from hslam_bringup.run_options import RunOptions
from hslam_ros.private_domain import private_domain

SAMPLES = Path(__file__).parents[1] / "bags" / "samples"
MOVED_M = 0.1
"""How far a node of a sample's atlas may lie from where it lay when the sample was recorded."""


def rebuilt(bag: Path, out: Path, **settings: dict[str, object]) -> Path:
    """Return the atlas made of a bag."""
    out.mkdir()
    options = RunOptions("", 0, out, settings)
    with Bag(bag) as opened:
        rebuild_atlas(opened, options)
    return options.atlas


def test_a_run_s_bag_makes_the_run_s_atlas(tmp_path: Path) -> None:
    run = tmp_path / "run"
    arguments = ("explore", "small_world", "--seed", "3", "--out", str(run), "--in-process", "--time-limit", "120")
    status, _, err = outcome(hslam(*arguments))
    assert status == 1, "the run is cut short"
    assert "not finished" in err
    same = rebuilt(run / "bag", tmp_path / "same")
    assert atlas_dump(same) == atlas_dump(run / "atlas.db")
    other = rebuilt(run / "bag", tmp_path / "other", ekf={"accept_gate": 2.0})
    assert atlas_dump(other) != atlas_dump(same)


@pytest.mark.parametrize("sample", sorted(path.parent.name for path in SAMPLES.glob("*/metadata.yaml")))
def test_a_sample_makes_the_atlas_it_was_recorded_with(tmp_path: Path, sample: str) -> None:
    """Same graph, nodes where they were: the last atlas message of the bag is what is expected."""
    with Bag(SAMPLES / sample) as bag:
        *_, last = bag.messages(TopicChoice(("/atlas/atlas",)))
    expected = deserialize_message(last.raw, Atlas)
    with AtlasStore(rebuilt(SAMPLES / sample, tmp_path / "out")) as store:
        server = AtlasServer(store=store)
        found = atlas_to_msg(server, node_poses(server.state.graph), last.log_ns)
    assert expected.closures >= 1, "a sample holds a loop closing"
    assert [(node.kind, list(node.edges)) for node in found.nodes] == [
        (node.kind, list(node.edges)) for node in expected.nodes
    ]
    for ours, theirs in zip(found.nodes, expected.nodes, strict=True):
        assert math.dist((ours.position.x, ours.position.y), (theirs.position.x, theirs.position.y)) < MOVED_M


def test_replay_through_the_nodes_makes_the_same_atlas(tmp_path: Path) -> None:
    """ekf_node and atlas_node live, the rest from the bag, in lock-step: bit for bit what one process makes of it."""
    with Bag(SAMPLES / "small_world_1") as bag:
        copy(bag, tmp_path / "bag", span_s=(0.0, 150.0))
    with private_domain() as domain:
        environment = os.environ | domain.environment
        nodes = [
            subprocess.Popen([str(executable("hslam_ekf", "ekf_node"))], env=environment),
            subprocess.Popen(
                [
                    str(executable("hslam_atlas", "atlas_node")),
                    *("--ros-args", "-p", "mission:=none", "-p", f"store:={tmp_path / 'atlas.db'}"),
                ],
                env=environment,
            ),
        ]
        try:
            replay = [str(executable("hslam_bags", "replay_node")), "--ros-args", "-p", f"path:={tmp_path / 'bag'}"]
            replay += ["-p", "lockstep:=true", "-p", "live:=ekf,atlas"]
            subprocess.run(replay, env=environment, check=True, timeout=120)
            for node in nodes:
                node.send_signal(signal.SIGINT)
            assert [node.wait(30) for node in nodes] == [0, 0]
        finally:
            for node in nodes:
                node.kill()
                node.wait()
    assert atlas_dump(tmp_path / "atlas.db") == atlas_dump(rebuilt(tmp_path / "bag", tmp_path / "out"))


def test_a_bag_without_what_an_atlas_is_made_of_is_refused(tmp_path: Path) -> None:
    with Bag(SAMPLES / "small_world_1") as bag:
        copy(bag, tmp_path / "bag", TopicChoice(("odom", "landmarks")))
    with pytest.raises(BagError, match=r"bag: topic /gvg/events: is not in the bag"):
        rebuilt(tmp_path / "bag", tmp_path / "out")


def damaged(path: Path) -> Path:
    """Return a bag whose messages begin well and break off in a damaged chunk."""
    with Bag(SAMPLES / "small_world_1") as bag:
        copy(bag, path, span_s=(0.0, 60.0))
    (file,) = path.glob("*.mcap")
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 64] = bytes(byte ^ 0xFF for byte in data[middle : middle + 64])
    file.write_bytes(data)
    return path


def without_odometry(path: Path) -> Path:
    """Return a bag of events alone."""
    with Bag(SAMPLES / "small_world_1") as bag:
        copy(bag, path, TopicChoice(("/gvg/events", "/landmarks")), span_s=(0.0, 60.0))
    return path


def absent(path: Path) -> Path:
    """Return the name of no bag."""
    return path


@pytest.mark.parametrize("bag", [absent, without_odometry, damaged])
@pytest.mark.parametrize("earlier", [b"precious", None])
def test_a_bag_that_makes_no_atlas_costs_no_earlier_one(
    tmp_path: Path, bag: Callable[[Path], Path], earlier: bytes | None
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    if earlier is not None:
        (out / "atlas.db").write_bytes(earlier)
        (out / "atlas.db-wal").write_bytes(earlier)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    status, _, err = outcome(hslam("rebuild", str(bag(tmp_path / "bag")), "--out", str(out), "--force"))
    assert status == 1
    assert err.count("\n") == 1
    assert "bag" in err
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_a_rebuilt_atlas_takes_the_place_of_the_earlier_one(tmp_path: Path) -> None:
    """And of what a killed process left beside it, or of a rebuild that was killed."""
    with Bag(SAMPLES / "small_world_1") as bag:
        copy(bag, tmp_path / "bag", span_s=(0.0, 60.0))
    expected = atlas_dump(rebuilt(tmp_path / "bag", tmp_path / "new"))
    out = tmp_path / "out"
    out.mkdir()
    for name in ("atlas.db", "atlas.db-wal", "atlas.db-journal"):
        (out / name).write_bytes(b"old" * 500)
    (out / "atlas.db.part").write_bytes((tmp_path / "new" / "atlas.db").read_bytes())
    status, _, err = outcome(hslam("rebuild", str(tmp_path / "bag"), "--out", str(out), "--force"))
    assert (status, err) == (0, "")
    assert [path.name for path in out.iterdir()] == ["atlas.db"]
    assert atlas_dump(out / "atlas.db") == expected


@pytest.mark.parametrize("content", [b"", b"no database" * 500, None])
def test_comparing_does_not_change_what_is_compared(tmp_path: Path, content: bytes | None) -> None:
    """An empty file, anything, another program's database."""
    path = tmp_path / "other.db"
    if content is None:
        with closing(sqlite3.connect(path)) as db:
            db.execute("CREATE TABLE addresses (name TEXT)")
    else:
        path.write_bytes(content)
    before = path.read_bytes()
    status, _, err = outcome(hslam("compare", str(path), str(path)))
    assert status == 1
    assert err.count("\n") == 1
    assert "other.db" in err
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["other.db"]
