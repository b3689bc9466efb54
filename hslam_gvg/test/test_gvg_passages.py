"""Which nodes a trail goes through, wherever between the walls it leads."""

import math
from itertools import pairwise

import numpy as np
import pytest
from drawn_walls import CROSSING, DEAD_END, T_JUNCTION, points_of
from hypothesis import given
from hypothesis import strategies as st
from test_gvg_local_graph import CONFIG, graph_of

from hslam_gvg.local_graph.local_graph import LocalGraph, local_graph
from hslam_gvg.local_graph.polyline import chord_bearing
from hslam_gvg.watching.passages import passages
from hslam_types.se2 import Array

CROSS = graph_of(CROSSING)
OFFSETS = st.floats(-0.9, 0.9)


def trail(*corners: tuple[float, float]) -> Array:
    """Return places 8 cm apart along straight lines."""
    parts = []
    for (x0, y0), (x1, y1) in pairwise(corners):
        share = np.linspace(0.0, 1.0, max(2, round(math.hypot(x1 - x0, y1 - y0) / 0.08)), endpoint=False)
        parts.append(np.column_stack((x0 + share * (x1 - x0), y0 + share * (y1 - y0))))
    return np.concatenate(parts)


def ways(graph: LocalGraph, places: Array) -> list[tuple[int, int, int]]:
    """Return the nodes gone through: degree, and the directions (degrees, to 90) in which the two ways lead away."""
    found = passages(graph, places)
    assert found is not None
    bearings = [[chord_bearing(way.path, 2.0) for way in graph.ways(passage.node)] for passage in found]
    turned = [[round(math.degrees(b) / 90.0) % 4 * 90 for b in each] for each in bearings]
    return [(graph.degree(p.node), to[p.came_by], to[p.left_by]) for p, to in zip(found, turned, strict=True)]


@given(OFFSETS, OFFSETS)
def test_straight_through_a_crossing_off_its_middle(before: float, after: float) -> None:
    assert ways(CROSS, trail((-4.0, before), (4.0, after))) == [(4, 180, 0)]


@given(OFFSETS, OFFSETS, st.sampled_from([0, 90, 180, 270]))
def test_round_a_corner_of_a_crossing(before: float, after: float, come_from: int) -> None:
    c, s = round(math.cos(math.radians(come_from))), round(math.sin(math.radians(come_from)))
    # Out of the east, and off to the left as the robot drives: south.
    places = trail((4.0, before), (after, before), (after, -4.0)) @ np.array([[c, s], [-s, c]])
    assert ways(CROSS, places) == [(4, come_from, (come_from + 270) % 360)]


def test_a_turn_about_at_the_crossing_and_none_before_it() -> None:
    assert ways(CROSS, trail((-4.0, 0.1), (0.2, 0.1), (-4.0, -0.1))) == [(4, 180, 180)]
    assert ways(CROSS, trail((-4.0, 0.1), (-2.2, 0.1), (-4.0, -0.1))) == []


def test_a_glance_into_another_branch_is_no_turn() -> None:
    assert ways(CROSS, trail((-4.0, 0.0), (0.0, 0.0), (0.0, 1.2), (0.0, 0.0), (4.0, 0.0))) == [(4, 180, 0)]


def test_who_looks_into_a_branch_of_which_little_is_known_has_gone_through_its_node_once() -> None:
    graph = local_graph(points_of(CROSSING, 0.0, step_m=0.04), lambda _, y: y < 1.0, 0.0, 0.0, CONFIG)
    assert graph is not None
    assert ways(graph, trail((-4.0, 0.0), (0.0, 0.0), (0.0, 1.1), (0.0, 0.0), (4.0, 0.0))) == [(4, 180, 0)]


def test_a_branch_is_left_by_only_once_it_is_taken() -> None:
    assert ways(CROSS, trail((-4.0, 0.0), (0.9, 0.0))) == []


def test_two_turns_are_two_passages_in_their_order() -> None:
    there_and_back = trail((-4.0, 0.0), (0.0, 0.0), (0.0, 3.0), (0.0, 0.0), (4.0, 0.0))
    assert ways(CROSS, there_and_back) == [(4, 180, 90), (4, 90, 0)]
    found = passages(CROSS, there_and_back)
    assert found is not None
    for passage in found:
        assert np.hypot(*there_and_back[passage.at]) < 0.1


def test_a_trail_that_begins_at_a_node_has_not_come_there() -> None:
    assert ways(CROSS, trail((0.0, 0.0), (4.0, 0.0))) == []


def test_who_turns_about_near_a_dead_end_has_been_there() -> None:
    graph = graph_of(DEAD_END, -2.0, 0.0)
    (end,) = graph.nodes()
    x = graph.hub(end).x
    assert ways(graph, trail((-5.0, 0.0), (x - 0.6, 0.0), (-5.0, 0.0))) == [(1, 180, 180)]
    assert ways(graph, trail((-5.0, 0.0), (x - 1.6, 0.0), (-5.0, 0.0))) == []


@pytest.mark.parametrize("walls", [T_JUNCTION, CROSSING])
def test_places_far_from_the_graph_say_nothing(walls: tuple[tuple[float, float, float, float], ...]) -> None:
    graph = graph_of(walls)
    assert ways(graph, trail((-4.0, 40.0), (4.0, 40.0))) == []
