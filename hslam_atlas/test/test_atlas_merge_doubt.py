"""Known answers of when one atlas may be laid on another."""

import math

import pytest
from scripted_level import EXACT, edge_map, row

from hslam_atlas.atlas_merge import _side_by_side
from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.part_joining import _doubt, _Way, _ways
from hslam_atlas.questions import Question
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import NodeKind

CLOSE, MARGIN = AtlasConfig().close_evidence, AtlasConfig().close_margin
Pairs = tuple[tuple[int, int], ...]


def way(pairs: Pairs, evidence: float) -> _Way:
    return _Way(9, 0, EXACT, frozenset(pairs), evidence)


@pytest.mark.parametrize(
    ("pairs", "others", "contradicts"),
    [
        pytest.param(((7, 0), (8, 1)), ((7, 0),), False, id="one says less"),
        pytest.param(((7, 0), (8, 1)), ((7, 0), (9, 2)), False, id="each says more of its own"),
        pytest.param(((7, 0), (8, 1)), ((7, 0), (8, 2)), True, id="an edge would be two"),
        pytest.param(((7, 0), (8, 1)), ((7, 0), (9, 1)), True, id="two edges would be one"),
        pytest.param(((7, 0),), ((8, 1),), True, id="nothing in common"),
    ],
)
def test_two_ways_contradict_each_other_where_both_cannot_be(pairs: Pairs, others: Pairs, contradicts: bool) -> None:
    assert way(pairs, 20.0).contradicts(way(others, 20.0)) == contradicts
    assert way(others, 20.0).contradicts(way(pairs, 20.0)) == contradicts


@pytest.mark.parametrize(
    ("evidence", "rivals", "why"),
    [
        (CLOSE, (), ""),
        (CLOSE - 0.1, (), "nats of the 9 that are asked for"),
        (20.0, (way(((8, 1),), 20.0 - MARGIN),), ""),
        (20.0, (way(((8, 1),), 20.1 - MARGIN),), "more than one way (20.0 and 15.1 nats)"),
        (20.0, (way(((7, 0), (8, 1)), 19.0),), ""),
    ],
)
def test_the_best_way_needs_evidence_and_a_lead_over_what_contradicts_it(
    evidence: float, rivals: tuple[_Way, ...], why: str
) -> None:
    best = way(((7, 0),), evidence)
    said = _doubt(best, [best, *rivals], AtlasConfig())
    assert why in said
    assert bool(said) == bool(why)


def test_no_way_at_all_is_told_as_that() -> None:
    assert "no edge of one looks like" in _doubt(None, [], AtlasConfig())


def twice(*, backwards: bool = False, seeds: tuple[int, int] = (0, 1)) -> AtlasState:
    """Return the row of corridors 0 and 1, and beside it another robot's: corridors 2 and 3, maybe driven backwards."""
    state = row()
    graph = state.graph
    for bearings in ([0.0], [math.pi, 0.0, 1.5], [math.pi]):
        graph.add_node(NodeKind.MEET_POINT if len(bearings) > 1 else NodeKind.BOUNDARY_POINT, 1.0, bearings)
    for edge in (graph.edges[0], graph.edges[1]):
        ends = tuple(EdgeEnd(end.node + 3, end.branch, end.frame_in_node) for end in edge.ends)
        seen = edge_map(100 + edge.id, seeds[edge.id])
        copy = graph.connect((ends[1], ends[0]) if backwards else (ends[0], ends[1]), 12.0, 1e-4, 12.0, seen.traversal)
        state.maps.put(copy.id, reverse(seen) if backwards else seen)
    return state


@pytest.mark.parametrize("backwards", [False, True])
def test_a_way_is_worth_its_matches_against_all_the_ways_there_could_be(backwards: bool) -> None:
    """Two edges that match, as far as look-alikes let them; each of two could lie on each of two, either way round."""
    state = twice(backwards=backwards)
    (found,) = _ways(state, {0, 1, 2}, {3, 4, 5})
    assert found.pairs == {(2, 0), (3, 1)}
    each = state.look_alikes.capped(1000.0)
    assert found.evidence == pytest.approx(2.0 * each - math.log(2 * 2 * 2), abs=0.01)


def test_edges_of_one_length_that_show_other_walls_are_no_way() -> None:
    assert not list(_ways(twice(seeds=(77, 78)), {0, 1, 2}, {3, 4, 5}))


def test_ids_and_numbers_of_the_second_follow_after_those_of_the_first() -> None:
    """Each has drives 0 and 1, a doubt that compared its edges, a link, and comparisons of places."""
    state = row()
    graph = state.graph
    graph.nodes[1].visits.append((4, 44))
    graph.add_link(2, 0, EXACT, 24.0)
    doubt = Question(2, 1, EXACT, 1.0, compared=frozenset({(0, 1)}))
    graph.changed_nodes.update(graph.nodes)
    graph.changed_edges.update(graph.edges)
    assert isinstance(state.maps, AtlasStore)
    state.maps.save(graph, [doubt], {"compared": 10, "alike": 2})
    with AtlasStore() as into:
        both, questions, from_node = _side_by_side(state.maps, state.maps, into, AtlasConfig())
        assert from_node == 3
        assert [edge.traversals for edge in both.graph.edges.values()] == [(0,), (1,), (5,), (6,)]
        assert [[end.node for end in edge.ends] for edge in both.graph.edges.values()] == [
            [0, 1],
            [1, 2],
            [3, 4],
            [4, 5],
        ]
        maps = [into.get(edge) for edge in both.graph.edges]
        assert [(seen.traversal, seen.arrival) for seen in maps] == [(0, 0), (1, 0), (5, 5), (6, 5)]
        assert both.graph.nodes[4].visits == [(9, 44)]
        assert both.graph.nodes[4].branches[1].edge == 3
        links = [(link.id, link.from_node, link.to_node) for link in both.graph.links.values()]
        assert links == [(0, 2, 0), (1, 5, 3)]
        asked = [(q.node, q.other, set(q.compared)) for q in questions.open]
        assert asked == [(2, 1, {(0, 1)}), (5, 4, {(2, 3)})]
        assert (both.look_alikes.compared, both.look_alikes.alike) == (20, 4)
