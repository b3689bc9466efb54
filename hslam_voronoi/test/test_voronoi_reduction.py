"""The reduction on graphs whose result is known, and what it never breaks."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_voronoi.branch_graph import BranchGraph
from hslam_voronoi.chains import joined_chains
from hslam_voronoi.reduction import reduce, spur_extent
from hslam_voronoi.rules import ReductionRules

RULES = ReductionRules()


def star(lengths: list[float], clearance: float) -> BranchGraph:
    """Return a meet point at the origin with straight branches of these lengths (m), evenly spread."""
    points, links = [[0.0, 0.0, clearance]], []
    for i, length in enumerate(lengths):
        angle = math.tau * i / len(lengths)
        links.append([0, len(points)])
        points.append([length * math.cos(angle), length * math.sin(angle), clearance])
    return joined_chains(np.array(points), np.array(links))


def ends_in_order(graph: BranchGraph) -> bool:
    """Whether every branch end is listed once, at the node the branch ends in."""
    listed = [end for hub in graph.hubs.values() for end in hub.ends]
    at_home = all(graph.branches[b].node(e) == n for n, hub in graph.hubs.items() for b, e in hub.ends)
    return at_home and sorted(listed) == sorted((b, e) for b in graph.branches for e in (0, 1))


def test_a_chain_of_points_is_one_branch() -> None:
    points = np.array([[float(x), 0.0, 1.0] for x in range(5)])
    graph = joined_chains(points, np.array([[2, 3], [0, 1], [3, 4], [1, 2]]))
    assert [branch.length for branch in graph.branches.values()] == [4.0]
    assert sorted(graph.hubs) == [0, 4]


def test_a_point_asked_for_is_a_node_within_a_chain() -> None:
    points = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]])
    graph = joined_chains(points, np.array([[0, 1], [1, 2]]), nodes={1})
    assert sorted(graph.hubs) == [0, 1, 2]


@pytest.mark.parametrize(("length", "kept"), [(1.45, False), (1.55, True)])
def test_a_spur_counts_from_one_and_a_half_clearances(length: float, kept: bool) -> None:
    # extent = length + d - d at the root: the spur's own length where the clearance is constant.
    graph = star([9.0, 9.0, length], 1.0)
    reduce(graph, RULES)
    assert (len(graph.branches) == 3) is kept


@pytest.mark.parametrize(("beyond", "kept"), [(0.0, False), (0.4, False), (0.6, True), (math.inf, True)])
def test_what_may_lie_beyond_the_known_counts_for_a_spur(beyond: float, kept: bool) -> None:
    graph = star([9.0, 9.0, 1.0], 1.0)
    reduce(graph, RULES, {3: beyond})
    assert (len(graph.branches) == 3) is kept


@pytest.mark.parametrize("wide", [1.0, 3.0, 5.0])
@pytest.mark.parametrize(("length", "kept"), [(0.5, False), (0.95, False), (1.05, True)])
def test_what_nobody_has_seen_needs_the_least_extent_however_wide_the_place(
    wide: float, length: float, kept: bool
) -> None:
    graph = star([30.0, 30.0, length], wide)
    reduce(graph, RULES, {3: 0.0}, unseen={3})
    assert (len(graph.branches) == 3) is kept


@pytest.mark.parametrize(("apart", "nodes"), [(0.9, 1), (1.1, 2)])
def test_meet_points_nearer_than_their_clearance_are_one(apart: float, nodes: int) -> None:
    points = [[0.0, 0.0, 1.0], [apart, 0.0, 1.0]]
    points += [[-6.0, 6.0, 1.0], [-6.0, -6.0, 1.0], [6.0 + apart, 6.0, 1.0], [6.0 + apart, -6.0, 1.0]]
    graph = joined_chains(np.array(points), np.array([[0, 1], [0, 2], [0, 3], [1, 4], [1, 5]]))
    reduce(graph, RULES)
    assert sum(len(hub.ends) > 1 for hub in graph.hubs.values()) == nodes


def test_the_extent_of_a_spur_reaches_to_its_last_obstacle() -> None:
    assert spur_extent(np.array([[0.0, 0.0, 1.0], [2.0, 0.0, 0.5]]), 1.0) == pytest.approx(1.5)


@given(st.lists(st.floats(0.2, 6.0), min_size=3, max_size=8), st.floats(0.3, 2.0))
def test_every_end_stays_at_its_node(lengths: list[float], clearance: float) -> None:
    graph = star(lengths, clearance)
    reduce(graph, RULES)
    assert graph.branches
    assert ends_in_order(graph)


@given(st.lists(st.floats(0.2, 6.0), min_size=3, max_size=8), st.floats(0.3, 2.0), st.data())
def test_knowing_that_more_lies_beyond_never_takes_a_branch_away(
    lengths: list[float], clearance: float, data: st.DataObject
) -> None:
    beyond = dict.fromkeys(data.draw(st.sets(st.integers(1, len(lengths)))), math.inf)
    with_more, without = star(lengths, clearance), star(lengths, clearance)
    reduce(with_more, RULES, beyond)
    reduce(without, RULES)
    assert len(with_more.branches) >= len(without.branches)
