"""The local graph gives the nodes of the reduced GVG, and no others."""

import math

import numpy as np
import pytest
from drawn_walls import ALCOVE, CROSSING, DEAD_END, HALF, L_CORNER, T_JUNCTION, Wall, points_of

from hslam_gvg.config import GvgConfig
from hslam_gvg.node_detector import NodeDetector
from hslam_gvg.reduced_graph import Branch, ReducedNode, distinct
from hslam_types.se2 import SE2, wrap

SEEDS = range(5)


def nodes_of(walls: tuple[Wall, ...], seed: int, turned: float = 0.0, noise_m: float = 0.02) -> list[ReducedNode]:
    points = SE2(0.0, 0.0, turned).apply_all(points_of(walls, noise_m, seed))
    return NodeDetector(GvgConfig()).graph(points, 0.1, -0.1).nodes


def assert_bearings(node: ReducedNode, expected: list[float], turned: float) -> None:
    assert node.degree == len(expected)
    for direction in expected:
        assert min(abs(wrap(b - direction - turned)) for b in node.bearings) < math.radians(8.0)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("turned", [0.0, 0.7, 2.9])
def test_a_t_junction_is_one_three_way_node(seed: int, turned: float) -> None:
    (node,) = nodes_of(T_JUNCTION, seed, turned)
    x, y = SE2(0.0, 0.0, turned).inverse().apply(node.x, node.y)
    assert (x, y) == pytest.approx((0.0, -0.3), abs=0.12)
    # The chords to 1.5 m lead from the node, which lies off the bar's middle line, back to that line.
    assert_bearings(node, [math.asin(0.2), math.pi - math.asin(0.2), -math.pi / 2.0], turned)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_crossing_is_one_four_way_node(seed: int) -> None:
    (node,) = nodes_of(CROSSING, seed)
    assert math.hypot(node.x, node.y) < 0.1
    assert_bearings(node, [0.0, math.pi / 2.0, math.pi, -math.pi / 2.0], 0.0)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("walls", [L_CORNER, ALCOVE])
def test_weak_meet_points_are_no_nodes(walls: tuple[Wall, ...], seed: int) -> None:
    assert nodes_of(walls, seed) == []


@pytest.mark.parametrize("seed", SEEDS)
def test_the_end_of_a_corridor_is_a_boundary_node(seed: int) -> None:
    (node,) = nodes_of(DEAD_END, seed)
    assert (node.x, node.y) == pytest.approx((0.0, 0.0), abs=0.2)
    assert node.clearance_m == pytest.approx(HALF, abs=0.1)
    assert_bearings(node, [math.pi], 0.0)


def test_homing_in_the_map_makes_the_place_repeat() -> None:
    detector, places = NodeDetector(GvgConfig()), []
    for seed in range(20):
        points = points_of(T_JUNCTION, 0.02, seed)
        node = detector.graph(points, 0.0, 0.0).nodes[0]
        homed = detector.homed(points, node)
        places.append((homed.x, homed.y))
    spread = np.hypot(*(np.array(places) - np.median(places, axis=0)).T)
    assert np.median(spread) < 0.03
    assert spread.max() < 0.15


def test_a_node_ahead_is_not_yet_passed_and_a_handled_one_is_hidden() -> None:
    detector, points = NodeDetector(GvgConfig()), points_of(T_JUNCTION, 0.02)
    path = [(x, 0.0) for x in (-2.0, -1.5, -1.0)]
    before, after = SE2(-1.0, 0.0, 0.0), SE2(1.0, -0.1, 0.0)
    assert detector.passed(detector.graph(points, -1.0, 0.0), before, path, []) is None
    path += [(-0.5, -0.1), (0.0, -0.2), (0.5, -0.2)]
    graph = detector.graph(points, 1.0, -0.1)
    assert detector.passed(graph, after, path, []) is not None
    assert detector.passed(graph, after, path, [(0.1, -0.3)]) is None


def test_branches_through_one_opening_are_one() -> None:
    def of(*bearings: float) -> list[Branch]:
        return [Branch(bearing, 1.0) for bearing in bearings]

    assert distinct(of(-3.0, 0.0, 0.3, 1.6)) == pytest.approx((-3.0, 0.15, 1.6))
    assert distinct(of(-3.1, 0.0, 3.1)) == pytest.approx((-math.pi, 0.0))


def test_a_squeeze_beside_a_wide_branch_is_none() -> None:
    branches = [Branch(-2.0, 1.0), Branch(0.0, 1.1), Branch(1.2, 0.45)]
    assert distinct(branches) == (-2.0, 0.0)
    assert distinct([*branches[:2], Branch(1.2, 0.9)]) == (-2.0, 0.0, 1.2)
    assert distinct([*branches[:2], Branch(1.5, 0.45)]) == (-2.0, 0.0, 1.5)
