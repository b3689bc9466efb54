"""Shortest ways against networkx on random graphs; closed edges are gone round."""

import math
from typing import Any

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_atlas.graph import AtlasGraph, EdgeEnd
from hslam_atlas.routes import PER_FAILURE_M, PER_NODE_M, outward
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

EXACT = UncertainPose.exact(SE2())


def tie(graph: AtlasGraph, u: int, v: int, length_m: float) -> int:
    ends = tuple(EdgeEnd(n, graph.nodes[n].add_branch(0.1 * len(graph.nodes[n].branches)).key, EXACT) for n in (u, v))
    return graph.connect((ends[0], ends[1]), length_m, 0.0, length_m, len(graph.edges)).id


@given(
    st.lists(
        st.tuples(st.integers(0, 6), st.integers(0, 6), st.floats(0.5, 30.0)).filter(lambda e: e[0] != e[1]),
        max_size=20,
    ),
    st.sets(st.integers(0, 19)),
)
def test_ways_are_as_short_as_networkx_finds_them(edges: list[tuple[int, int, float]], closed: set[int]) -> None:
    graph = AtlasGraph()
    expected: Any = nx.Graph()
    for _ in range(7):
        expected.add_node(graph.add_node(NodeKind.MEET_POINT, 1.0, []).id)
    for u, v, length_m in edges:
        edge = tie(graph, u, v, length_m)
        cost = length_m + PER_NODE_M
        if edge not in closed and cost < expected.get_edge_data(u, v, {"weight": math.inf})["weight"]:
            expected.add_edge(u, v, weight=cost)
    found = {there.node: there.cost_m for there in outward(graph, 0, list(graph.nodes[0].branches), closed)}
    truth = nx.single_source_dijkstra_path_length(expected, 0)
    del truth[0]
    back = found.pop(0, None)
    nearest = min((there["weight"] for there in expected[0].values()), default=None)
    assert back == (None if nearest is None else pytest.approx(2 * nearest))
    assert found == pytest.approx(truth)


def test_a_way_tells_the_branch_it_leaves_by() -> None:
    graph = AtlasGraph()
    for _ in range(3):
        graph.add_node(NodeKind.MEET_POINT, 1.0, [])
    tie(graph, 0, 1, 30.0)
    tie(graph, 0, 2, 5.0)
    tie(graph, 2, 1, 5.0)
    ways = {there.node: there for there in outward(graph, 0, (0, 1))}
    assert [ways[1].first, ways[1].cost_m] == [1, 10.0 + 2 * PER_NODE_M]
    assert next(outward(graph, 0, (0,))).cost_m == 30.0 + PER_NODE_M
    assert not list(outward(graph, 0, (0,), {0}))


def test_who_cannot_see_the_way_on_may_come_back_and_see_it() -> None:
    """From 0 a dead end leads to 1; the only way on, to 2, is not in sight now."""
    graph = AtlasGraph()
    for _ in range(3):
        graph.add_node(NodeKind.MEET_POINT, 1.0, [])
    tie(graph, 0, 1, 3.0)
    tie(graph, 0, 2, 5.0)
    graph.nodes[0].branches[1].unseen = 1
    there = {way.node: way for way in outward(graph, 0, (0,), tries=3)}
    assert [there[0].first, there[0].cost_m] == [0, 2 * (3.0 + PER_NODE_M)]
    assert [there[2].first, there[2].cost_m] == [0, there[0].cost_m + 5.0 + PER_NODE_M + PER_FAILURE_M]
    graph.nodes[0].branches[1].unseen = 3
    assert 2 not in {way.node for way in outward(graph, 0, (0,), tries=3)}


def test_stopping_at_a_node_costs_as_much_as_six_metres() -> None:
    """The way of one long edge against that of two short ones: from 6 m on the shorter one is worth its stop."""
    for longer_m, first in ((5.9, 0), (6.1, 1)):
        graph = AtlasGraph()
        for _ in range(3):
            graph.add_node(NodeKind.MEET_POINT, 1.0, [])
        tie(graph, 0, 1, 10.0 + longer_m)
        tie(graph, 0, 2, 4.0)
        tie(graph, 2, 1, 6.0)
        assert next(there for there in outward(graph, 0, (0, 1)) if there.node == 1).first == first


def test_a_way_of_three_edges_is_the_sum_of_them_by_its_first_branch() -> None:
    graph = AtlasGraph()
    for _ in range(4):
        graph.add_node(NodeKind.MEET_POINT, 1.0, [])
    for u, v, length_m in ((1, 2, 3.0), (0, 1, 2.0), (2, 3, 4.0)):
        tie(graph, u, v, length_m)
    found = [tuple(there) for there in outward(graph, 0, (0,)) if there.node != 0]
    assert found == [(1, 8.0, 0), (2, 17.0, 0), (3, 27.0, 0)]


def test_what_was_counted_on_in_vain_is_gone_round_then_not_counted_on() -> None:
    """From 0 to 2 straight, or by 1; what is in sight now, at the start, need not have been so before."""
    graph = AtlasGraph()
    for _ in range(4):
        graph.add_node(NodeKind.MEET_POINT, 1.0, [])
    tie(graph, 0, 2, 5.0)
    tie(graph, 0, 1, 5.0)
    tie(graph, 1, 2, 5.0)
    tie(graph, 2, 3, 5.0)
    straight, onward = graph.nodes[0].branches[0], graph.nodes[2].branches[2]
    direct_m, round_m = 5.0 + PER_NODE_M, 10.0 + 2 * PER_NODE_M

    def cost_m(node: int) -> float | None:
        return next((way.cost_m for way in outward(graph, 0, (0, 1), tries=3) if way.node == node), None)

    straight.unseen = 2
    assert cost_m(2) == direct_m
    straight.attempts = 1
    assert cost_m(2) == round_m
    onward.unseen = 2
    assert cost_m(3) == round_m + direct_m + 2 * PER_FAILURE_M
    onward.attempts = 1
    assert cost_m(3) is None
