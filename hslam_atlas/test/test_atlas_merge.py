"""Two nodes become one: what their edges may and may not look like."""

import math
from dataclasses import replace

import pytest
from test_atlas_alignment import EAST, WEST, drives
from test_atlas_tie import FORWARD, shortened

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.merge import merge, take_out
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


def test_a_branch_only_the_younger_has_is_added_in_its_direction_and_counted_by_its_visits() -> None:
    """The younger node's frame is turned by a radian against the older one's."""
    state = bare([0.0], [0.0, 2.0])
    gone, kept = state.graph.nodes[1], state.graph.nodes[0]
    kept.visits += [(1, 1), (2, 2)]
    gone.visits += [(3, 3)]
    assert merge(state, 1, 0, UncertainPose.exact(SE2(0.1, 0.0, 1.0)))
    assert [branch.bearing for branch in kept.branches.values()] == pytest.approx([0.0, 1.0, 3.0])
    # The first is shown by the visits to the older alone, the others by the one to the younger.
    assert [(branch.seen, branch.missed) for branch in kept.branches.values()] == [(1, 1), (1, 0), (1, 0)]
    assert kept.visits == [(1, 1), (2, 2), (3, 3)]


@pytest.mark.parametrize("order", [(1, 0), (0, 1)])
def test_the_older_id_stays_and_the_pose_is_turned_about_where_it_is_given_the_other_way(
    order: tuple[int, int],
) -> None:
    state = bare([0.0, 2.0], [0.0, 2.0])
    pose = UncertainPose.exact(SE2(0.3, -0.1, 0.2))
    assert merge(state, *order, pose if order == (1, 0) else pose.inverse())
    (merged,) = state.merged
    assert (merged.gone, merged.kept, merged.branches) == (1, 0, {0: 0, 1: 1})
    assert merged.gone_in_kept.pose == pytest.approx(pose.pose)


def test_a_meet_point_and_a_dead_end_are_never_one() -> None:
    state = bare([0.0], [0.0])
    state.graph.nodes[1].kind = NodeKind.BOUNDARY_POINT
    assert not merge(state, 1, 0, FORWARD)


@pytest.mark.parametrize(("branches", "one"), [(3, True), (4, False)])
def test_one_branch_may_be_misread_and_no_more(branches: int, one: bool) -> None:
    assert merge(bare([0.0, 2.0], [0.0, 2.0, 4.0, 1.0][:branches]), 1, 0, FORWARD) == one


def bare(*bearings: list[float]) -> AtlasState:
    """Return nodes without edges."""
    config = AtlasConfig()
    store = AtlasStore()
    graph, _ = store.load()
    for each in bearings:
        graph.add_node(NodeKind.MEET_POINT, 1.3, each)
    return AtlasState(config, graph, store, LookAlikes(config.repetition))


def test_far_ends_become_one_where_they_are_whatever_their_frames() -> None:
    """The younger pair's frames are turned; what was about its far node stays where the drive has shown it."""
    state = bare([0.0], [0.0], [0.0], [0.0])
    turned = UncertainPose.exact(SE2(0.2, -0.1, 0.5))
    state.graph.nodes[3].branches[0].bearing = 0.5
    connect(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(1, 0, FORWARD), replace(WEST_1, traversal=1)))
    connect(state, Drive(EdgeEnd(2, 0, FORWARD), EdgeEnd(3, 0, turned), replace(WEST_2, traversal=2)))
    assert merge(state, 2, 0, FORWARD)
    near, far = state.merged
    assert (near.gone, near.kept, far.gone, far.kept) == (2, 0, 3, 1)
    assert far.gone_in_kept.pose == pytest.approx(turned.pose.inverse(), abs=0.15)


def test_where_the_older_far_node_is_the_younger_node_s_the_far_ends_change_places() -> None:
    state = bare([0.0], [0.5], [0.0], [0.0])
    turned = UncertainPose.exact(SE2(0.2, -0.1, 0.5))
    connect(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), replace(WEST_1, traversal=1)))
    connect(state, Drive(EdgeEnd(3, 0, FORWARD), EdgeEnd(1, 0, turned), replace(WEST_2, traversal=2)))
    assert merge(state, 3, 0, FORWARD)
    _, far = state.merged
    assert (far.gone, far.kept) == (2, 1)
    assert far.gone_in_kept.pose == pytest.approx(turned.pose, abs=0.15)


def test_a_node_that_takes_another_in_is_not_taken_in_itself_at_once() -> None:
    """Node 2 is to be node 1; the edges on their branches then say that node 1 is node 0: one after the other."""
    state = bare([0.0], [0.0, math.pi], [0.0, math.pi])
    connect(state, Drive(EdgeEnd(1, 0, FORWARD), EdgeEnd(0, 0, FORWARD), replace(WEST_1, traversal=1)))
    connect(state, Drive(EdgeEnd(2, 0, FORWARD), EdgeEnd(1, 1, FORWARD), replace(WEST_2, traversal=2)))
    before = everything(state)
    assert not merge(state, 2, 1, FORWARD)
    assert everything(state) == before


def test_an_edge_taken_out_leaves_where_its_far_node_lies() -> None:
    state = bare([0.0], [0.0])
    turned = UncertainPose.exact(SE2(0.2, -0.1, 0.5))
    edge = connect(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(1, 0, turned), WEST_1))
    there = edge.across(0).pose
    take_out(state, edge.id)
    (measured,) = state.graph.links.values()
    assert (measured.from_node, measured.to_node) == (0, 1)
    assert measured.to_in_from.pose == pytest.approx(there)
    assert state.loosened == {0, 1}


def test_an_edge_that_turns_out_to_come_back_by_its_own_branch_is_none() -> None:
    state = bare([0.0, 2.0, 4.0], [0.0, 2.0, 4.0])
    connect(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(1, 0, FORWARD), WEST_1))
    assert merge(state, 1, 0, FORWARD)
    (node,) = state.graph.nodes.values()
    assert {branch.edge for branch in node.branches.values()} == {None}
    assert (state.graph.edges, state.graph.links) == ({}, {})


def test_an_edge_that_comes_back_by_another_branch_stays() -> None:
    state = bare([0.0, 2.0, 4.0], [0.0, 2.0, 4.0])
    connect(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(1, 1, FORWARD), WEST_1))
    assert merge(state, 1, 0, FORWARD)
    (edge,) = state.graph.edges.values()
    assert [(end.node, end.branch) for end in edge.ends] == [(0, 0), (0, 1)]
