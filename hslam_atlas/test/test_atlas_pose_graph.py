"""The optimised picture is exact without noise and better than the chain with it."""

import math

import numpy as np
import pytest

from hslam_atlas.chain import chained
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.pose_graph import optimised
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2, wrap

SIDES = 12


def ring(noise_m: float, noise_rad: float, seed: int) -> tuple[AtlasGraph, list[SE2]]:
    """Return a ring of nodes tied by measured links, and the nodes' true poses in the first one's frame."""
    rng = np.random.default_rng(seed)
    step = SE2(10.0, 0.0, 2.0 * math.pi / SIDES)
    truth = [SE2()]
    for _ in range(SIDES - 1):
        truth.append(truth[-1] @ step)
    graph = AtlasGraph()
    for _ in truth:
        graph.add_node(NodeKind.MEET_POINT, 1.0, [0.0])
    for i in range(SIDES):
        error = SE2(*(rng.normal(size=3) * [noise_m, noise_m, noise_rad]).tolist())
        graph.add_link(i, (i + 1) % SIDES, UncertainPose.diagonal(step @ error, noise_m, noise_rad), 10.0)
    return graph, truth


def rms(poses: dict[int, SE2], truth: list[SE2]) -> float:
    """Return the root mean square position error (m)."""
    return math.sqrt(sum((p.x - truth[n].x) ** 2 + (p.y - truth[n].y) ** 2 for n, p in poses.items()) / len(truth))


def test_without_noise_it_is_the_truth() -> None:
    graph, truth = ring(0.0, 0.0, seed=1)
    poses = optimised(graph, 0)
    assert rms(poses, truth) < 1e-6
    assert all(abs(wrap(pose.theta - truth[node].theta)) < 1e-6 for node, pose in poses.items())


def test_the_cycle_makes_it_better_than_the_chain() -> None:
    better = []
    for seed in range(10):
        graph, truth = ring(0.05, 0.02, seed)
        chain = {node: pose.pose for node, pose in chained(graph, 0).items()}
        better.append(rms(optimised(graph, 0), truth) < rms(chain, truth))
    assert sum(better) >= 8


def test_another_anchor_gives_the_same_shape() -> None:
    graph, _ = ring(0.05, 0.02, seed=3)
    at_zero, at_five = optimised(graph, 0), optimised(graph, 5)
    for node, pose in at_five.items():
        moved = at_zero[5].to(at_zero[node])
        assert (moved.x, moved.y) == pytest.approx((pose.x, pose.y), abs=5e-3)
