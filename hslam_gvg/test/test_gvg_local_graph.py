"""The local graph is the truth's reduction of what is known, and ends where knowledge ends."""

import math

import numpy as np
import pytest
from drawn_walls import ALCOVE, CROSSING, DEAD_END, L_CORNER, T_JUNCTION, Wall, points_of

from hslam_gvg.local_graph.cuts import Mask
from hslam_gvg.local_graph.gaps import OPEN, SHUT, UNKNOWN, Gaps
from hslam_gvg.local_graph.graph_config import LocalGraphConfig, RingGraphConfig
from hslam_gvg.local_graph.local_graph import LocalGraph, local_graph
from hslam_gvg.local_graph.polyline import chord_bearing
from hslam_types.se2 import Array

CONFIG = LocalGraphConfig()


def all_known(x: Array, _: Array) -> Mask:
    """Say that every place is known to be free."""
    return np.ones(len(x), bool)


def graph_of(walls: tuple[Wall, ...], x: float = 0.0, y: float = 0.0, noise_m: float = 0.0) -> LocalGraph:
    """Return the local graph of densely sampled walls, all known."""
    graph = local_graph(points_of(walls, noise_m, step_m=0.04), all_known, x, y, CONFIG)
    assert graph is not None
    return graph


def meet_points(graph: LocalGraph) -> list[tuple[float, float, int]]:
    """Return place and degree of the nodes with more than one way."""
    hubs = [(graph.hub(number), graph.degree(number)) for number in graph.nodes()]
    return [(hub.x, hub.y, degree) for hub, degree in hubs if degree > 1]


@pytest.mark.parametrize("noise_m", [0.0, 0.01])
@pytest.mark.parametrize(("walls", "degree"), [(T_JUNCTION, 3), (CROSSING, 4)])
def test_a_junction_is_one_meet_point(walls: tuple[Wall, ...], degree: int, noise_m: float) -> None:
    found = meet_points(graph_of(walls, 0.3, 0.1, noise_m))
    assert [d for _, _, d in found] == [degree]
    # A T's point lies off the middle of the corridor, towards the stem, at equal distance of wall and corners.
    assert math.hypot(found[0][0], found[0][1]) < 0.45


@pytest.mark.parametrize("walls", [L_CORNER, ALCOVE])
def test_a_corner_and_an_alcove_are_no_nodes(walls: tuple[Wall, ...]) -> None:
    graph = graph_of(walls, -2.0, 0.0)
    assert meet_points(graph) == []
    assert len(graph.paths()) == 1


def test_a_dead_end_is_a_node_of_one_way() -> None:
    graph = graph_of(DEAD_END, -2.0, 0.0)
    (end,) = graph.nodes()
    assert graph.degree(end) == 1
    assert -1.0 < graph.hub(end).x < 1.1
    assert abs(graph.hub(end).y) < 0.1


def test_ways_leave_counter_clockwise() -> None:
    graph = graph_of(CROSSING)
    (number,) = [n for n in graph.nodes() if graph.degree(n) == 4]
    bearings = [chord_bearing(way.path, 0.7) for way in graph.ways(number)]
    turns = np.diff(np.unwrap(bearings))
    assert (turns > 0.0).all()
    assert turns == pytest.approx([math.pi / 2] * 3, abs=0.05)


def test_paths_run_at_equal_distance_of_both_walls_and_say_their_clearance() -> None:
    path = np.vstack([path for _, path in graph_of(L_CORNER, -3.0, 0.0).paths()])
    straight = path[(path[:, 0] < -1.5) & (path[:, 0] > -3.5)]
    assert np.abs(straight[:, 1]).max() < 0.03
    assert straight[:, 2] == pytest.approx(np.full(len(straight), 1.2), abs=0.03)


@pytest.mark.parametrize(("width_m", "open_"), [(0.60, True), (0.50, True), (0.38, False)])
def test_a_way_wide_enough_for_the_body_is_passable_whatever_its_width(width_m: float, open_: bool) -> None:
    half = 0.5 * width_m
    door: tuple[Wall, ...] = ((-6, 1.2, -half, 1.2), (half, 1.2, 6, 1.2), (-6, -1.2, 6, -1.2))
    sides: tuple[Wall, ...] = ((-half, 1.2, -3, 1.25), (-3, 1.25, -3, 5), (3, 5, 3, 1.25), (3, 1.25, half, 1.2))
    room: tuple[Wall, ...] = (*sides, (-3, 5, 3, 5))
    reached = max(path[:, 1].max() for _, path in graph_of(door + room, -0.5, 0.0).paths())
    assert bool(reached > 2.0) is open_


def test_what_is_not_known_ends_in_an_exit() -> None:
    points = points_of(CROSSING, step_m=0.04)
    graph = local_graph(points, lambda x, _: x < 2.0, 0.0, 0.0, CONFIG)
    assert graph is not None
    ends = [way.end for number in graph.nodes() for way in graph.ways(number) if way.path[-1, 0] > 1.5]
    assert len(ends) == 1
    assert graph.is_exit(ends[0])
    assert graph.hub(ends[0]).x == pytest.approx(2.0, abs=0.5)
    assert ends[0] not in graph.nodes()


def test_walls_in_the_unknown_are_no_dead_end() -> None:
    graph = local_graph(points_of(DEAD_END, step_m=0.04), lambda x, _: x < -2.0, -4.0, 0.0, CONFIG)
    assert graph is not None
    assert graph.nodes() == []


def test_a_spur_into_the_unknown_counts_until_it_is_known_to_be_short() -> None:
    points = points_of(ALCOVE, step_m=0.04)
    unknown = local_graph(points, lambda x, y: (y < 0.6) | (np.abs(x) > 1.0), -1.5, 0.0, CONFIG)
    known = local_graph(points, all_known, -1.5, 0.0, CONFIG)
    assert unknown is not None
    assert known is not None
    assert len(known.paths()) <= len(unknown.paths())


def test_a_lone_ring_can_be_followed() -> None:
    angle = np.linspace(0.0, math.tau, 400)
    circle = np.column_stack((np.cos(angle), np.sin(angle)))
    graph = local_graph(np.concatenate((1.0 * circle, 3.0 * circle)), all_known, 2.0, 0.0, CONFIG)
    assert graph is not None
    ((_, path),) = graph.paths()
    assert np.hypot(path[:, 0], path[:, 1]) == pytest.approx(np.full(len(path), 2.0), abs=0.05)


def test_nothing_in_reach_makes_no_graph() -> None:
    assert local_graph(np.zeros((0, 2)), lambda x, _: np.zeros(len(x), bool), 0.0, 0.0, CONFIG) is None


def test_ways_on_go_through_hidden_nodes_and_stop_at_others() -> None:
    graph = graph_of(T_JUNCTION, -3.0, 0.0)
    (junction,) = [n for n in graph.nodes() if graph.degree(n) == 3]
    (branch,) = [number for number, path in graph.paths() if path[:, 0].min() < -4.0]
    path = dict(graph.paths())[branch]
    index = len(path) // 2
    towards = [f for f in (True, False) if graph.onwards(branch, index, f, 9.0, lambda _: False)[0].end == junction]
    assert len(towards) == 1
    assert len(graph.onwards(branch, index, towards[0], 9.0, lambda _: True)) == 2


def graph_by_ring(state: int, gap_m: float = 1.0) -> LocalGraph:
    """Return the graph of a corridor whose end has a gap in its middle, of which so much is known."""
    half = 0.5 * gap_m
    walls = ((-8, 1.2, 1.2, 1.2), (1.2, 1.2, 1.2, half), (1.2, -half, 1.2, -1.2), (1.2, -1.2, -8, -1.2))

    def gaps(begin: Array, end: Array) -> Gaps:
        return np.where(np.minimum(begin[:, 0], end[:, 0]) > 1.1, state, OPEN).astype(np.int8)

    graph = local_graph(points_of(walls, step_m=0.04), all_known, -1.0, 0.0, RingGraphConfig(), gaps)
    assert graph is not None
    return graph


def test_the_end_of_a_corridor_with_a_shut_gap_is_a_dead_end() -> None:
    graph = graph_by_ring(SHUT)
    (end,) = graph.nodes()
    assert graph.degree(end) == 1
    assert not graph.is_doubtful(end)


def test_an_open_gap_leads_on() -> None:
    graph = graph_by_ring(OPEN)
    assert graph.nodes() == []
    assert max(path[:, 0].max() for _, path in graph.paths()) > 2.0


def test_an_end_beside_a_gap_that_nobody_knows_is_doubtful() -> None:
    graph = graph_by_ring(UNKNOWN)
    assert max(path[:, 0].max() for _, path in graph.paths()) < 1.3
    assert all(graph.is_doubtful(number) for number in graph.nodes())
    ends = [way.end for number in graph.nodes() for way in graph.ways(number)]
    assert ends or not graph.nodes()


def test_a_ridge_into_the_unknown_is_followed_while_the_space_is_free() -> None:
    # Two walls heard up to x = 0, free space up to x = 1.5.
    walls = ((-8, 1.2, 0, 1.2), (-8, -1.2, 0, -1.2))
    graph = local_graph(points_of(walls, step_m=0.04), lambda x, _: x < 1.5, -1.0, 0.0, RingGraphConfig())
    assert graph is not None
    assert max(path[:, 0].max() for _, path in graph.paths()) == pytest.approx(1.45, abs=0.15)
