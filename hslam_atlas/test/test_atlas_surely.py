"""A place known better than nodes are apart: the node is beyond doubt, and what contradicts is a matter of branches."""

import math
from dataclasses import replace

import pytest
from test_atlas_merge import EAST_1, EAST_2, WEST_1, WEST_2, doubled
from test_atlas_tie import FORWARD, OTHER_WAY, SAME_WAY, SHORT, WAY, atlas_with, shortened

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.hypothesis import is_surely_at
from hslam_atlas.merge import merge
from hslam_atlas.retrace import on_one_way
from hslam_atlas.tie import Drive, Outcome, connect, tie
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

CONFIG = AtlasConfig()
UNKNOWN_WAY = replace(shortened(OTHER_WAY, WAY.terminal_x), path_length_m=WAY.path_length_m)


@pytest.mark.parametrize(
    ("x", "std_m", "exclusive_m", "sure"),
    [
        pytest.param(0.1, 0.05, 1.0, True, id="there"),
        pytest.param(0.1, 0.05, 20.0, True, id="walls unheard"),
        pytest.param(0.1, 0.25, 1.0, False, id="anywhere about"),
        pytest.param(0.6, 0.15, 20.0, False, id="maybe beyond the disc that holds no other"),
        pytest.param(0.4, 0.05, 0.5, False, id="where another node may be"),
        pytest.param(0.4, 0.001, 20.0, False, id="beyond what repeats"),
    ],
)
def test_sure_is_what_lies_nearer_than_any_other_node_can(
    x: float, std_m: float, exclusive_m: float, sure: bool
) -> None:
    for direction in (0.0, 2.0, -1.0):
        place = SE2(x * math.cos(direction), x * math.sin(direction), 1.0)
        assert is_surely_at(UncertainPose.diagonal(place, std_m, 0.01), exclusive_m, CONFIG) is sure


@pytest.mark.parametrize("sure", [False, True])
def test_a_drive_between_sure_nodes_takes_the_place_of_an_edge_driven_once(sure: bool) -> None:
    state, edge = atlas_with(WAY, 1)
    outcome = tie(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), UNKNOWN_WAY), sure=sure)
    assert outcome is (Outcome.CONNECTED if sure else Outcome.CONTRADICTED)
    assert (edge.id in state.graph.edges) is not sure
    assert len(state.graph.edges) == 1
    assert len(state.graph.links) == int(sure)


def test_an_edge_that_misled_as_often_as_it_was_driven_is_no_more() -> None:
    state, edge = atlas_with(WAY, 3)
    elsewhere = Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), UNKNOWN_WAY)
    for attempts in (1, 2):
        assert tie(state, elsewhere, sure=True) is Outcome.PASSED
        assert edge.id in state.graph.edges
        assert state.graph.nodes[0].branches[0].attempts == attempts
    assert tie(state, elsewhere, sure=True) is Outcome.CONNECTED
    assert edge.id not in state.graph.edges


@pytest.mark.parametrize(("driven", "stays"), [(1, False), (2, True)])
def test_a_drive_along_a_known_edge_speaks_against_another_on_its_branch(driven: int, stays: bool) -> None:
    """The branch was taken to lead to node 2, the drive matches the edge to node 1."""
    state, _ = atlas_with(WAY, 2)
    graph = state.graph
    beside = graph.nodes[0].add_branch(0.3)
    ends = EdgeEnd(0, beside.key, FORWARD), EdgeEnd(2, 0, FORWARD)
    misleading = connect(state, Drive(*ends, replace(UNKNOWN_WAY, traversal=-1)))
    graph.put_edge(replace(misleading, traversals=tuple(range(-driven, 0))))
    drive = Drive(EdgeEnd(0, beside.key, FORWARD), EdgeEnd(1, graph.nodes[1].add_branch(0.3).key, FORWARD), SAME_WAY)
    assert tie(state, drive, sure=True) is Outcome.RETRACED
    assert (misleading.id in graph.edges) is stays
    assert beside.attempts == 1
    assert not beside.unexplored


@pytest.mark.parametrize("driven", [1, 2])
def test_a_drive_into_a_branch_that_leads_elsewhere_gets_a_branch_beside(driven: int) -> None:
    """How a robot comes into a node tells less well which branch it was than how it leaves."""
    state, edge = atlas_with(WAY, driven)
    drive = Drive(EdgeEnd(2, 0, FORWARD), EdgeEnd(0, 0, FORWARD), UNKNOWN_WAY)
    assert tie(state, drive, sure=True) is Outcome.CONNECTED
    (new,) = state.graph.edges.keys() - {edge.id}
    assert [(end.node, end.branch) for end in state.graph.edges[new].ends] == [(2, 0), (0, 1)]
    came_by = reverse(UNKNOWN_WAY).departure_heading
    assert state.graph.nodes[0].branches[1].bearing == pytest.approx(came_by)


def test_a_drive_of_another_length_that_went_elsewhere_is_not_of_that_branch() -> None:
    state, edge = atlas_with(WAY, 2)
    drive = Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), shortened(OTHER_WAY, SHORT))
    assert tie(state, drive, sure=True) is Outcome.PASSED
    assert edge.id in state.graph.edges
    assert tie(state, drive, sure=True) is Outcome.CONNECTED
    assert edge.id not in state.graph.edges


@pytest.mark.parametrize(
    ("second", "nodes", "edges"),
    [
        pytest.param((shortened(EAST_2, 8.0), EAST_2), 4, 3, id="one way is the same"),
        pytest.param((EAST_2, WEST_2), 5, 4, id="none is"),
    ],
)
def test_sure_nodes_become_one_and_ways_that_contradict_stay(
    second: tuple[EdgeMap, EdgeMap], nodes: int, edges: int
) -> None:
    state = doubled((WEST_1, EAST_1), second)
    assert merge(state, 1, 0, FORWARD, sure=True)
    assert (len(state.graph.nodes), len(state.graph.edges)) == (nodes, edges)
    carried = [branch.edge for branch in state.graph.nodes[0].branches.values() if branch.edge is not None]
    assert sorted(carried) == sorted(state.graph.edges)


def test_what_matches_is_one_for_sure_nodes_too() -> None:
    state = doubled((WEST_1, EAST_1), (WEST_2, EAST_2))
    assert merge(state, 1, 0, FORWARD, sure=True)
    assert [edge.traversals for edge in state.graph.edges.values()] == [(0, 10), (1, 11)]


def test_no_merge_makes_a_dead_end_of_a_meet_point() -> None:
    state = doubled((WEST_1, EAST_1), (WEST_2, EAST_2))
    state.graph.nodes[1].kind = NodeKind.BOUNDARY_POINT
    assert not merge(state, 1, 0, FORWARD, sure=True)
    assert len(state.graph.nodes) == 6


@pytest.mark.parametrize(("turned", "one_way"), [(0.0, True), (math.pi, False)])
def test_a_way_that_ends_beyond_the_longer_ones_reach_is_another(turned: float, one_way: bool) -> None:
    """Too few landmarks to speak: what is left of the longer way must reach from one end to the other."""
    state, edge = atlas_with(WAY, 1)
    drive = shortened(SAME_WAY, SHORT)
    bare = replace(drive, landmarks=drive.landmarks[:0], covariance=drive.covariance[:2, :2], sightings=())
    frame = UncertainPose.exact(SE2(0.0, 0.0, turned))
    assert on_one_way(state, edge, 0, bare, frame) is one_way
