"""Scores: perfect on the truth itself, and exactly as much worse as what was taken from it or changed in it."""

import dataclasses
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hslam_report.explored import ExploredEdge, ExploredGraph, ExploredNode, Visit
from hslam_report.isomorphism import embedding_of_explored, embedding_of_truth, isomorphism
from hslam_report.path_score import core_paths
from hslam_report.score import score_graph
from hslam_sim.truth import Rules, TrueGvg, TrueNode
from hslam_sim.truth.true_gvg import single_gvg
from hslam_sim.worlds import load_world
from hslam_types.gvg_events import NodeKind


@pytest.fixture(scope="module")
def truth() -> TrueGvg:
    return single_gvg(load_world("wean_hall_6"), Rules())


def perfect(truth: TrueGvg, rng: random.Random | None = None) -> ExploredGraph:
    """Return the truth as an exploration would: other numbers, branches counted from another one, two visits a node."""
    rng = rng or random.Random(0)
    numbers = rng.sample(range(100, 1000), len(truth.nodes))
    turn = [rng.randrange(max(node.degree, 1)) for node in truth.nodes]

    def branch(node: int, end: tuple[int, int]) -> int:
        return (truth.nodes[node].branches.index(end) + turn[node]) % truth.nodes[node].degree

    nodes = [
        ExploredNode(
            numbers[index],
            NodeKind.BOUNDARY_POINT if node.is_boundary else NodeKind.MEET_POINT,
            node.degree,
            node.clearance_m,
            (Visit(2 * index, node.x + 0.05, node.y), Visit(2 * index + 1, node.x, node.y - 0.1)),
        )
        for index, node in enumerate(truth.nodes)
    ]
    edges = []
    for index, edge in enumerate(truth.edges):
        ends = [(edge.u, (index, 0)), (edge.v, (index, 1))]
        rng.shuffle(ends)
        (u, end_u), (v, end_v) = ends
        edges.append(ExploredEdge(numbers[u], numbers[v], branch(u, end_u), branch(v, end_v), 1.03 * edge.length_m))
    rng.shuffle(nodes)
    return ExploredGraph(tuple(nodes), tuple(edges))


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_the_truth_under_other_names_is_perfect(truth: TrueGvg, seed: int) -> None:
    score = score_graph(perfect(truth, random.Random(seed)), truth)
    assert (score.node_precision, score.node_recall, score.edge_precision, score.edge_recall) == (1.0, 1.0, 1.0, 1.0)
    assert score.isomorphic
    assert (score.loop_closures_true, score.loop_closures_false, score.loop_closures_missed) == (4, 0, 0)
    assert (score.nodes, score.edges, score.true_nodes, score.true_edges) == (13, 16, 13, 16)


def test_the_isomorphism_found_is_the_one_of_the_places(truth: TrueGvg) -> None:
    graph = perfect(truth)
    nodes = isomorphism(embedding_of_explored(graph), embedding_of_truth(truth))
    assert nodes == score_graph(graph, truth).matches.core


@pytest.mark.parametrize("which", range(16))
def test_a_missing_edge_is_seen(truth: TrueGvg, which: int) -> None:
    graph = perfect(truth)
    score = score_graph(dataclasses.replace(graph, edges=graph.edges[:which] + graph.edges[which + 1 :]), truth)
    assert not score.isomorphic
    assert score.edge_recall == pytest.approx(15 / 16)
    assert score.edge_precision == 1.0


def test_the_mirror_image_and_one_swapped_pair_of_branches_are_no_isomorphisms(truth: TrueGvg) -> None:
    graph = perfect(truth)
    degree = {node.id: node.degree for node in graph.nodes}

    def with_branches(changed: dict[int, dict[int, int]]) -> ExploredGraph:
        edges = tuple(
            dataclasses.replace(
                edge,
                branch_u=changed.get(edge.u, {}).get(edge.branch_u, edge.branch_u),
                branch_v=changed.get(edge.v, {}).get(edge.branch_v, edge.branch_v),
            )
            for edge in graph.edges
        )
        return dataclasses.replace(graph, edges=edges)

    mirrored = with_branches({n: {b: d - 1 - b for b in range(d)} for n, d in degree.items()})
    assert not score_graph(mirrored, truth).isomorphic
    for node, branches in degree.items():
        if branches >= 3:
            assert not score_graph(with_branches({node: {0: 1, 1: 0}}), truth).isomorphic


def test_two_places_taken_for_one_are_a_false_closure(truth: TrueGvg) -> None:
    graph = perfect(truth)
    ends = [node for node in graph.nodes if node.kind is NodeKind.BOUNDARY_POINT]
    one, other = ends[0], ends[1]
    merged = dataclasses.replace(one, visits=one.visits + other.visits, degree=2)
    nodes = tuple(merged if node is one else node for node in graph.nodes if node is not other)
    edges = tuple(
        dataclasses.replace(e, u=one.id if e.u == other.id else e.u, v=one.id if e.v == other.id else e.v)
        for e in graph.edges
    )
    score = score_graph(ExploredGraph(nodes, edges), truth)
    assert (score.loop_closures_false, score.loop_closures_true) == (1, 4)
    assert not score.isomorphic
    assert score.node_recall == pytest.approx(12 / 13)


def test_one_place_kept_as_two_nodes_is_a_missed_closure(truth: TrueGvg) -> None:
    graph = perfect(truth)
    node = next(node for node in graph.nodes if node.degree == 4)
    twin = dataclasses.replace(node, id=1, visits=node.visits[1:], degree=1)
    moved = next(i for i, e in enumerate(graph.edges) if e.u == node.id)
    edges = tuple(dataclasses.replace(e, u=1, branch_u=0) if i == moved else e for i, e in enumerate(graph.edges))
    score = score_graph(ExploredGraph((*graph.nodes, twin), edges), truth)
    assert score.loop_closures_missed == 1
    assert score.loop_closures_true == 3
    assert score.node_precision == pytest.approx(13 / 14)
    assert not score.isomorphic


def test_an_invented_node_costs_precision_but_an_optional_one_does_not(truth: TrueGvg) -> None:
    graph = perfect(truth)
    invented = ExploredNode(1, NodeKind.MEET_POINT, 3, 1.2, (Visit(90, 84.0, 26.0),))
    more = dataclasses.replace(graph, nodes=(*graph.nodes, invented))
    assert score_graph(more, truth).node_precision == pytest.approx(13 / 14)
    known = TrueNode(84.1, 26.0, 1.2, truth.nodes[0].kind, ((0, 0), (0, 1), (1, 0)), core=False)
    kinds = [node for node in truth.nodes if not node.is_boundary]
    excused = dataclasses.replace(truth, only_in_variants=(dataclasses.replace(known, kind=kinds[0].kind),))
    assert score_graph(more, excused).node_precision == 1.0


def test_a_wrong_length_is_a_wrong_edge(truth: TrueGvg) -> None:
    graph = perfect(truth)
    longer = dataclasses.replace(graph.edges[0], length_m=1.5 * graph.edges[0].length_m + 2.0)
    score = score_graph(dataclasses.replace(graph, edges=(longer, *graph.edges[1:])), truth)
    assert [score.edge_precision, score.edge_recall] == pytest.approx([15 / 16, 15 / 16])


def test_an_unfinished_exploration_is_scored_too(truth: TrueGvg) -> None:
    graph = perfect(truth)
    alone = score_graph(ExploredGraph(graph.nodes[:1], ()), truth)
    assert [alone.node_recall, alone.node_precision, alone.edge_recall] == pytest.approx([1 / 13, 1.0, 0.0])
    nothing = score_graph(ExploredGraph((), ()), truth)
    assert (nothing.node_recall, nothing.node_precision, nothing.isomorphic) == (0.0, 0.0, False)


def test_core_paths_run_through_optional_nodes_only() -> None:
    edges = [(0, 7, 1.0), (7, 8, 2.0), (7, 9, 4.0), (8, 1, 3.0), (9, 1, 3.0), (1, 2, 5.0), (2, 2, 6.0)]
    paths = core_paths(edges, {0: 10, 1: 11, 2: 12})
    assert {ends: sorted(lengths) for ends, lengths in paths.items()} == {
        (10, 11): [6.0, 8.0],
        (11, 11): [12.0],
        (11, 12): [5.0],
        (12, 12): [6.0],
    }
