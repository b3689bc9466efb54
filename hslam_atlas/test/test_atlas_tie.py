"""A drive of another length on the branch of a known edge: which of the two stays."""

import math
from dataclasses import replace

import numpy as np
import pytest
from test_atlas_alignment import EAST, WEST, drives

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import Edge, EdgeEnd
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.retrace import compare
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.tie import Drive, Outcome, connect, tie
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

FORWARD = UncertainPose.exact(SE2())


def shortened(edge_map: EdgeMap, length_m: float) -> EdgeMap:
    """Return the map a drive would have made that had stopped on the way."""
    kept = np.flatnonzero(edge_map.landmarks[:, 0] < length_m + 3.0)
    rows = np.concatenate(([0, 1], (2 + 2 * kept[:, None] + np.arange(2)).reshape(-1)))
    return replace(
        edge_map,
        traversal=edge_map.traversal + 1000,
        terminal_x=length_m,
        landmarks=edge_map.landmarks[kept],
        covariance=edge_map.covariance[np.ix_(rows, rows)],
        sightings=tuple(edge_map.sightings[i] for i in kept),
        path_length_m=length_m,
    )


def atlas_with(edge_map: EdgeMap, driven: int) -> tuple[AtlasState, Edge]:
    """Return three nodes of one branch each, an edge between the first two that was driven so many times."""
    config = AtlasConfig()
    store = AtlasStore()
    graph, _ = store.load()
    for _ in range(3):
        graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0])
    state = AtlasState(config, graph, store, LookAlikes(config.repetition))
    edge = connect(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(1, 0, FORWARD), edge_map))
    edge = replace(edge, traversals=tuple(range(driven)))
    graph.put_edge(edge)
    return state, edge


WAY, SAME_WAY = drives(2, 60, bearing=WEST)
(OTHER_WAY,) = drives(1, 62, bearing=EAST)
SHORT = 12.0


@pytest.mark.parametrize(
    ("known", "driven", "drive", "outcome"),
    [
        pytest.param(WAY, 3, shortened(SAME_WAY, SHORT), Outcome.CONNECTED, id="the edge had passed a node"),
        pytest.param(shortened(WAY, SHORT), 1, SAME_WAY, Outcome.PASSED, id="the drive passed a node"),
        pytest.param(shortened(OTHER_WAY, SHORT), 1, WAY, Outcome.CONNECTED, id="the edge was never confirmed"),
        pytest.param(shortened(OTHER_WAY, SHORT), 2, WAY, Outcome.PASSED, id="longer, but elsewhere"),
        pytest.param(WAY, 2, shortened(OTHER_WAY, SHORT), Outcome.PASSED, id="shorter, but elsewhere"),
    ],
)
def test_what_both_passed_decides_then_how_often(known: EdgeMap, driven: int, drive: EdgeMap, outcome: Outcome) -> None:
    state, edge = atlas_with(known, driven)
    assert tie(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), drive)) is outcome
    assert (edge.id in state.graph.edges) == (outcome is Outcome.PASSED)
    assert len(state.graph.edges) == 1
    assert len(state.graph.links) == 1


def test_a_dead_end_cannot_have_been_passed_unnoticed() -> None:
    state, edge = atlas_with(WAY, 1)
    state.graph.nodes[2].kind = NodeKind.BOUNDARY_POINT
    drive = Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), shortened(SAME_WAY, SHORT))
    assert tie(state, drive) is Outcome.PASSED
    assert edge.id in state.graph.edges


def test_a_drive_with_one_bad_homing_is_still_along_its_edge() -> None:
    """The far meet point is taken for 0.4 m farther on: more than six times what it mostly scatters."""
    state, edge = atlas_with(WAY, 1)
    stray = replace(SAME_WAY, terminal_x=SAME_WAY.terminal_x + 0.4)
    match = compare(state, edge, 0, stray, FORWARD)
    assert match is not None
    assert match.agrees
    assert compare(state, edge, 0, replace(OTHER_WAY, terminal_x=WAY.terminal_x), FORWARD) is None


def loop_of(clearances: float, branch: int) -> Outcome:
    """Return what becomes of a drive from a node back to itself, so many of its clearances long."""
    config = AtlasConfig()
    store = AtlasStore()
    graph, _ = store.load()
    graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0, 2.0])
    state = AtlasState(config, graph, store, LookAlikes(config.repetition))
    drive = replace(WAY, path_length_m=1.3 * clearances)
    return tie(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(0, branch, FORWARD), drive))


@pytest.mark.parametrize(("clearances", "outcome"), [(3.1, Outcome.RETURNED), (3.3, Outcome.CONNECTED)])
def test_a_loop_that_is_hardly_longer_than_the_free_disc_goes_round_nothing(
    clearances: float, outcome: Outcome
) -> None:
    assert loop_of(clearances, 1) is outcome


def test_a_way_back_by_the_branch_it_left_is_no_loop_however_long() -> None:
    assert loop_of(30.0, 0) is Outcome.RETURNED


def beside(edge_map: EdgeMap) -> tuple[AtlasState, Edge]:
    """Return an edge between two nodes, each with a second branch, and a third node with one."""
    state, edge = atlas_with(edge_map, 1)
    for node in (0, 1):
        state.graph.nodes[node].add_branch(0.4)
    return state, edge


def test_an_edge_driven_by_branches_invented_beside_its_own_is_that_edge() -> None:
    state, edge = beside(WAY)
    drive = replace(SAME_WAY, traversal=70)
    assert tie(state, Drive(EdgeEnd(0, 1, FORWARD), EdgeEnd(1, 1, FORWARD), drive)) is Outcome.RETRACED
    assert state.graph.edges[edge.id].traversals == (0, 70)
    for node in (0, 1):
        own, invented = state.graph.nodes[node].branches.values()
        assert (own.given_up, invented.given_up, invented.edge) == (False, True, None)


def test_left_by_its_own_branch_and_arrived_by_an_invented_one_it_is_that_edge_too() -> None:
    state, edge = beside(WAY)
    drive = replace(SAME_WAY, traversal=70)
    assert tie(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(1, 1, FORWARD), drive)) is Outcome.RETRACED
    assert state.graph.edges[edge.id].traversals == (0, 70)
    assert [branch.given_up for branch in state.graph.nodes[1].branches.values()] == [False, True]
    assert not state.graph.nodes[0].branches[0].given_up


@pytest.mark.parametrize(
    ("stop", "drive"),
    [pytest.param(2, SAME_WAY, id="to another node"), pytest.param(1, OTHER_WAY, id="by another way")],
)
def test_a_drive_beside_a_known_edge_to_elsewhere_or_by_another_way_is_an_edge_of_its_own(
    stop: int, drive: EdgeMap
) -> None:
    state, edge = beside(WAY)
    if stop == 2:
        state.graph.nodes[2].branches[0].edge = None
    end = EdgeEnd(stop, 1 if stop == 1 else 0, FORWARD)
    assert tie(state, Drive(EdgeEnd(0, 1, FORWARD), end, replace(drive, traversal=70))) is Outcome.CONNECTED
    assert len(state.graph.edges) == 2
    assert state.graph.edges[edge.id].traversals == (0,)


def test_a_known_edge_driven_to_a_node_not_known_to_be_its_end_makes_the_two_one() -> None:
    """The third node's frame is turned: what is about it stays where it is."""
    state, edge = atlas_with(WAY, 1)
    turned = UncertainPose.exact(SE2(0.1, 0.2, 2.0))
    state.graph.nodes[2].branches[0].bearing = 2.0
    drive = Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, turned), replace(SAME_WAY, traversal=70))
    assert tie(state, drive) is Outcome.GLUED
    (merged,) = state.merged
    assert (merged.gone, merged.kept, merged.branches) == (2, 1, {0: 0})
    assert merged.gone_in_kept.pose == pytest.approx(turned.pose.inverse(), abs=0.15)
    assert state.graph.edges[edge.id].traversals == (0, 70)


def test_what_a_drive_that_brought_no_edge_measured_stays_as_a_link() -> None:
    state, _ = atlas_with(shortened(OTHER_WAY, SHORT), 2)
    turned = UncertainPose.exact(SE2(0.3, 0.1, 0.7))
    assert tie(state, Drive(EdgeEnd(0, 0, turned), EdgeEnd(2, 0, turned), WAY)) is Outcome.PASSED
    (measured,) = state.graph.links.values()
    expected = turned.pose @ SE2(WAY.terminal_x, 0.0, math.pi) @ turned.pose.inverse()
    assert measured.to_in_from.pose == pytest.approx(expected)
    assert state.graph.nodes[0].branches[0].attempts == 1


def test_a_new_edge_forgets_drives_in_vain() -> None:
    state, edge = atlas_with(WAY, 1)
    state.graph.remove_edge(edge.id)
    state.graph.nodes[0].branches[0].attempts = 2
    assert tie(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), SAME_WAY)) is Outcome.CONNECTED
    assert state.graph.nodes[0].branches[0].attempts == 0
