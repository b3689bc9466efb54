"""Known answers about poses chained along edges and links, and what moves with a node that becomes part of another."""

import math

import numpy as np
import pytest

from hslam_atlas.chain import chained
from hslam_atlas.graph import AtlasGraph, Branch, EdgeEnd
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

ASKEW = UncertainPose.diagonal(SE2(1.0, -2.0, -1.1), 0.05, 0.01)
BENT = UncertainPose.diagonal(SE2(3.0, 1.0, 0.7), 0.1, 0.02)
EXACT = UncertainPose.exact(SE2())


def nodes(count: int) -> AtlasGraph:
    graph = AtlasGraph()
    for _ in range(count):
        graph.add_node(NodeKind.MEET_POINT, 1.0, [])
    return graph


def tie(graph: AtlasGraph, u: int, v: int, length_m: float, frames: tuple[SE2, SE2] = (SE2(), SE2())) -> int:
    ends = [
        EdgeEnd(node, graph.nodes[node].add_branch(0.0).key, UncertainPose.exact(frame))
        for node, frame in zip((u, v), frames, strict=True)
    ]
    return graph.connect((ends[0], ends[1]), length_m, 0.01, length_m, len(graph.edges)).id


@pytest.mark.parametrize(("direct_m", "by_three"), [(12.9, False), (13.1, True)])
def test_a_hop_costs_a_chain_three_metres(direct_m: float, by_three: bool) -> None:
    """From node 0 to node 1 at once, or over node 2 in 10 m and one hop more; where it is then tells the way."""
    graph = nodes(3)
    graph.add_link(0, 1, UncertainPose.exact(SE2(1.0, 0.0, 0.0)), direct_m)
    graph.add_link(0, 2, EXACT, 4.0)
    graph.add_link(2, 1, UncertainPose.exact(SE2(3.0, 0.0, 0.0)), 6.0)
    assert chained(graph, 0)[1].pose.x == (3.0 if by_three else 1.0)


def test_the_shortest_of_three_hops_is_found_by_all_its_lengths() -> None:
    graph = nodes(4)
    for u, v, x in ((0, 2, 9.0), (2, 3, 1.0), (3, 1, 1.0)):
        graph.add_link(u, v, UncertainPose.exact(SE2(x, 0.0, 0.0)), x)
    graph.add_link(0, 1, UncertainPose.exact(SE2(0.5, 0.0, 0.0)), 16.0)
    assert chained(graph, 0)[1].pose.x == 0.5  # 19 m against 11 m and 9 m for three hops


def test_links_compose_in_order_and_backwards_by_their_inverse() -> None:
    graph = nodes(3)
    graph.add_link(0, 1, BENT, 3.0)
    graph.add_link(2, 1, ASKEW, 3.0)
    there = chained(graph, 0)
    assert there[1].pose == pytest.approx(BENT.pose)
    assert there[2].pose == pytest.approx(BENT.pose @ ASKEW.pose.inverse())
    back = chained(graph, 1)
    assert back[0].pose == pytest.approx(BENT.pose.inverse())
    assert back[0].covariance == pytest.approx(BENT.inverse().covariance)


def test_an_edge_leads_over_its_terminal_to_the_far_node() -> None:
    """Node 1 lies at the edge's far end, 10 m on, and its frame is turned against the edge's there."""
    graph = nodes(2)
    here, there = SE2(0.0, 0.0, 0.5), SE2(0.2, 0.1, 1.0)
    tie(graph, 0, 1, 10.0, (here, there))
    expected = here @ SE2(10.0, 0.0, math.pi) @ there.inverse()
    assert chained(graph, 0)[1].pose == pytest.approx(expected)
    assert chained(graph, 1)[0].pose == pytest.approx(expected.inverse())
    along = np.array([math.cos(0.5), math.sin(0.5)])
    assert chained(graph, 0)[1].covariance[:2, :2] == pytest.approx(0.01 * np.outer(along, along), abs=1e-12)


def test_edges_and_links_keep_where_they_lead_when_their_node_becomes_part_of_another() -> None:
    graph = nodes(4)
    tie(graph, 3, 1, 10.0, (SE2(0.0, 0.0, 0.3), SE2(0.0, 0.0, 0.2)))
    graph.add_link(3, 2, BENT, 5.0)
    graph.add_link(1, 3, BENT, 50.0)
    graph.add_link(3, 0, BENT, 70.0)
    before = chained(graph, 3)
    branch = graph.nodes[0].add_branch(0.0).key
    graph.absorb(3, 0, BENT, {0: branch})
    after = chained(graph, 0)
    for node in (1, 2):
        assert after[node].pose == pytest.approx(BENT.pose @ before[node].pose)
    assert len(graph.links) == 2  # the one between the two is within one node
    back = next(link for link in graph.links.values() if link.from_node == 1)
    assert back.to_node == 0
    assert back.to_in_from.pose == pytest.approx(BENT.pose @ BENT.pose.inverse())


def test_a_branch_that_the_other_nodes_visits_did_not_show_is_given_up_as_if_they_had_been_here() -> None:
    graph = nodes(2)
    kept, gone = graph.nodes[0], graph.nodes[1]
    shown, invented = kept.add_branch(0.0), kept.add_branch(2.0)
    gone.add_branch(0.0)
    gone.visits += [(1, 1), (2, 2)]
    graph.absorb(1, 0, EXACT, {0: shown.key})
    assert (shown.seen, shown.missed, shown.given_up) == (2, 0, False)
    assert (invented.seen, invented.missed, invented.given_up) == (1, 2, True)


@pytest.mark.parametrize(
    ("seen", "missed", "edge", "gone"),
    [(1, 2, None, True), (1, 1, None, False), (2, 2, None, False), (0, 1, None, False), (1, 9, 4, False)],
)
def test_only_what_two_visits_and_most_did_not_show_is_given_up(
    seen: int, missed: int, edge: int | None, gone: bool
) -> None:
    branch = Branch(0, 0.0, edge, seen, missed)
    branch.give_up_if_absent()
    assert branch.given_up == gone
