"""Two nodes become one: what their edges may and may not look like."""

import math
from dataclasses import replace

import pytest
from test_atlas_alignment import EAST, WEST, drives
from test_atlas_tie import FORWARD, shortened

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.merge import merge
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.tie import Drive, connect
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

WEST_1, WEST_2 = drives(2, 60, bearing=WEST)
EAST_1, EAST_2 = drives(2, 70, bearing=EAST)
EAST_FRAME = UncertainPose.exact(SE2(0.0, 0.0, math.pi))


def doubled(first: tuple[EdgeMap, EdgeMap], second: tuple[EdgeMap, EdgeMap]) -> AtlasState:
    """Return nodes 0 and 1, maybe one, each with an edge west and one east to a node of its own."""
    config = AtlasConfig()
    store = AtlasStore()
    graph, _ = store.load()
    state = AtlasState(config, graph, store, LookAlikes(config.repetition))
    for _ in range(2):
        graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0, math.pi])
    for node, maps in enumerate((first, second)):
        for branch, edge_map in enumerate(maps):
            far = graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0])
            frame = EAST_FRAME if branch else FORWARD
            drive = replace(edge_map, traversal=10 * node + branch)
            connect(state, Drive(EdgeEnd(node, branch, frame), EdgeEnd(far.id, 0, FORWARD), drive))
    return state


def test_edges_that_match_become_one_and_so_do_their_ends() -> None:
    state = doubled((WEST_1, EAST_1), (WEST_2, EAST_2))
    assert merge(state, 1, 0, FORWARD)
    assert len(state.graph.nodes) == 3
    assert [edge.traversals for edge in state.graph.edges.values()] == [(0, 10), (1, 11)]


def test_of_two_edges_one_way_the_longer_had_passed_a_node() -> None:
    state = doubled((WEST_1, EAST_1), (shortened(WEST_2, 12.0), EAST_2))
    assert merge(state, 1, 0, FORWARD)
    assert min(edge.path_length_m for edge in state.graph.edges.values()) == pytest.approx(12.0)
    assert len(state.graph.edges) == 2
    (link,) = state.graph.links.values()
    assert link.path_length_m == pytest.approx(WEST_1.path_length_m)


@pytest.mark.parametrize(
    "second",
    [
        pytest.param((shortened(EAST_2, 8.0), EAST_2), id="another way of another length"),
        pytest.param((EAST_2, WEST_2), id="other ways"),
        pytest.param((shortened(WEST_2, 12.0), shortened(EAST_2, 8.0)), id="two nodes passed"),
    ],
)
def test_a_contradiction_leaves_everything_as_it_was(second: tuple[EdgeMap, EdgeMap]) -> None:
    state = doubled((WEST_1, EAST_1), second)
    before = everything(state)
    assert not merge(state, 1, 0, FORWARD)
    assert everything(state) == before


def everything(state: AtlasState) -> tuple[object, ...]:
    """Return all that a state holds: graph and maps as an atlas file keeps them, bit for bit, and what is not in it."""
    graph = state.graph
    graph.changed_nodes.update(graph.nodes)
    graph.changed_edges.update(graph.edges)
    graph.changed_links.update(graph.links)
    with AtlasStore() as written:
        for edge_id in graph.edges:
            written.put(edge_id, state.maps.get(edge_id))
        written.save(graph, [], {"compared": state.look_alikes.compared, "alike": state.look_alikes.alike})
        content = tuple(written.dump())
    return content, tuple(state.merged), frozenset(state.loosened), state.closures
