"""What a run does when things break: it says what in one line, ends non-zero, and what it recorded stays readable."""

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from whole_runs import atlas_dump, hslam, outcome, wait_until

from hslam_bags.bag import Bag

NAMED_WITHIN_S = 10.0


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["no_such_world"], "no_such_world"),
        (["small_world", "--set", "ekf.accept_gate=-1.0"], "accept_gate"),
        (["small_world", "--set", "gvg.no_such_parameter=1"], "no_such_parameter"),
        (["small_world", "--set", "scout.watchdog_s=1.0"], "one of sim, gvg, ekf, atlas"),
    ],
)
def test_bad_input_is_one_line_that_names_it(tmp_path: Path, arguments: list[str], told: str) -> None:
    status, _, err = outcome(hslam("explore", *arguments, "--in-process", "--out", str(tmp_path / "run")))
    assert status == 1
    (line,) = err.strip().splitlines()
    assert line.startswith("hslam: ")
    assert told in line


def test_a_broken_world_file_is_told_with_its_name(tmp_path: Path) -> None:
    world = tmp_path / "broken.yaml"
    world.write_text("corridors: [")
    status, _, err = outcome(hslam("explore", str(world), "--out", str(tmp_path / "run")))
    assert status == 1
    assert err.count("\n") == 1
    assert "broken.yaml" in err


def test_an_earlier_run_is_not_overwritten_unasked(tmp_path: Path) -> None:
    (tmp_path / "atlas.db").write_bytes(b"precious")
    status, _, err = outcome(hslam("explore", "small_world", "--out", str(tmp_path)))
    assert status == 1
    assert "--force" in err
    assert (tmp_path / "atlas.db").read_bytes() == b"precious"
    for slip in (["no_such_world"], ["small_world", "--set", "ekf.acept_gate=9"]):
        status, _, err = outcome(hslam("explore", *slip, "--out", str(tmp_path), "--force"))
        assert status == 1
        assert err.count("\n") == 1
        assert [path.name for path in tmp_path.iterdir()] == ["atlas.db"]
        assert (tmp_path / "atlas.db").read_bytes() == b"precious", "a typing error costs no run"


@pytest.fixture
def exploring(tmp_path: Path) -> Iterator["subprocess.Popen[str]"]:
    """Yield a run of separate processes whose bag has begun to grow."""
    run = hslam("explore", "small_world", "--seed", "3", "--out", str(tmp_path / "run"))
    bag = tmp_path / "run" / "bag" / "bag_0.mcap"
    try:
        wait_until(lambda: run.poll() is not None or (bag.exists() and bag.stat().st_size > 300_000))
        assert run.poll() is None, run.communicate()
        yield run
    finally:
        run.send_signal(signal.SIGINT)
        run.wait()


def node_pid(name: str, parent: int) -> int:
    """Return the process of a node that a run has started."""
    (pid,) = (
        child.pid
        for child in psutil.Process(parent).children()
        if any(f"{name}_node" in part for part in child.cmdline())
    )
    return pid


def assert_readable(run: Path) -> None:
    """Check that a run's bag and atlas can be read."""
    with Bag(run / "bag", tolerant=True) as bag:
        assert sum(1 for message in bag.messages() if message.topic == "/odom") > 20
    assert any("CREATE TABLE nodes" in line for line in atlas_dump(run / "atlas.db"))


@pytest.mark.parametrize("node", ["ekf", "sim", "record"])
def test_a_killed_node_is_named_in_time(exploring: "subprocess.Popen[str]", tmp_path: Path, node: str) -> None:
    os.kill(node_pid(node, exploring.pid), signal.SIGKILL)
    killed_s = time.monotonic()
    status, _, err = outcome(exploring)
    assert status == 1
    assert f"node '{'recorder' if node == 'record' else node}' was ended by SIGKILL" in err
    assert time.monotonic() - killed_s < NAMED_WITHIN_S
    assert_readable(tmp_path / "run")


def test_a_frozen_node_is_named_in_time(exploring: "subprocess.Popen[str]", tmp_path: Path) -> None:
    pid = node_pid("ekf", exploring.pid)
    os.kill(pid, signal.SIGSTOP)
    status, _, err = outcome(exploring)  # which kills the frozen node at its end
    assert not psutil.pid_exists(pid)
    assert status == 1
    assert "no answer from" in err
    assert "ekf" in err
    assert_readable(tmp_path / "run")


def test_nodes_do_not_outlive_a_killed_runner(exploring: "subprocess.Popen[str]") -> None:
    nodes = psutil.Process(exploring.pid).children()
    exploring.kill()
    gone, alive = psutil.wait_procs(nodes, timeout=NAMED_WITHIN_S)
    assert (len(gone), alive) == (5, [])


def test_ctrl_c_closes_bag_and_atlas_whole(exploring: "subprocess.Popen[str]", tmp_path: Path) -> None:
    exploring.send_signal(signal.SIGINT)
    status, _, err = outcome(exploring)
    assert status == 130
    assert "interrupted" in err
    with Bag(tmp_path / "run" / "bag") as bag:  # intolerant: any damage raises
        assert bag.counts["/odom"] > 20
    assert_readable(tmp_path / "run")
