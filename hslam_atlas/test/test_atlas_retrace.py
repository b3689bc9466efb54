"""Known answers of what counts as a drive along a known edge, and as its beginning."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scripted_level import EXACT, edge_map, row

from hslam_atlas import retrace
from hslam_atlas.config import AtlasConfig
from hslam_atlas.hypothesis import Sight
from hslam_atlas.retrace import compare, convinces, on_one_way, similar_length
from hslam_atlas.sighting import branch_towards, observe, sight_of
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2, rotation

CONFIG = AtlasConfig()


def kept(full: EdgeMap, indices: list[int]) -> EdgeMap:
    """Return a map with some of its landmarks."""
    size = 2 + 2 * len(indices)
    covariance = 1e-4 * np.eye(size)
    covariance[1, 1] = 0.0
    return replace(full, landmarks=full.landmarks[indices], sightings=(9,) * len(indices), covariance=covariance)


@pytest.mark.parametrize(("a_m", "b_m", "alike"), [(10.0, 11.9, True), (10.0, 12.0, False), (100.0, 107.6, True)])
def test_lengths_of_one_edge_differ_by_a_part_of_the_longer_and_a_fixed_part(
    a_m: float, b_m: float, alike: bool
) -> None:
    """1.2 m and 6 per cent."""
    assert similar_length(a_m, b_m, CONFIG) == alike
    assert similar_length(b_m, a_m, CONFIG) == alike


@pytest.mark.parametrize(
    ("departure", "arrival", "compared"), [(0.0, 0.0, True), (1.0, 0.0, True), (0.0, 1.0, True), (1.0, 1.0, False)]
)
def test_a_drive_that_leaves_and_arrives_otherwise_is_another_way(
    departure: float, arrival: float, compared: bool
) -> None:
    state = row()
    drive = replace(edge_map(9, 0), departure_heading=departure, arrival_heading=math.pi - arrival)
    assert (compare(state, state.graph.edges[0], 0, drive, EXACT) is not None) == compared


def test_an_edge_too_short_for_a_direction_is_compared_by_the_poses_of_both_frames() -> None:
    """A loop whose ends are 2 m apart: the drive's frame is turned by 20 degrees against the edge's."""
    state = row()
    turn = math.radians(20.0)
    stored = replace(edge_map(0, 0), terminal_x=2.0)
    state.maps.put(0, stored)
    seen = replace(stored, landmarks=stored.landmarks @ rotation(turn))
    frame = UncertainPose.exact(SE2(0.0, 0.0, turn))
    right = compare(state, state.graph.edges[0], 0, seen, frame)
    assert right is not None
    assert right.agrees
    assert right.alignment.offset.theta == pytest.approx(turn, abs=0.02)
    wrong = compare(state, state.graph.edges[0], 0, seen, frame.inverse())
    assert wrong is not None
    assert not wrong.agrees


@pytest.mark.parametrize(("landmarks", "agrees", "convinced"), [(3, False, True), (4, False, False), (9, True, True)])
def test_with_hardly_a_landmark_lengths_must_do(landmarks: int, agrees: bool, convinced: bool) -> None:
    state = row()
    edge = state.graph.edges[0]
    match = compare(state, edge, 0, edge_map(9, 0), EXACT)
    assert match is not None
    drive = kept(edge_map(9, 0), list(range(landmarks)))
    assert convinces(replace(match, agrees=agrees), edge, drive, state) == convinced
    assert not convinces(None, edge, drive, state)


@pytest.mark.parametrize(("shown", "way"), [(12, True), (6, True), (5, False)])
def test_half_of_what_both_passed_makes_one_way(shown: int, way: bool) -> None:
    """Of the twelve landmarks as far as the shorter drive went so many are in the other map, the rest elsewhere."""
    state = row()
    edge = state.graph.edges[0]
    rng = np.random.default_rng(1)
    places = np.column_stack((np.linspace(0.5, 5.5, 12), np.tile([1.0, -1.0], 6)))
    others = np.column_stack((rng.uniform(0.5, 5.0, 12), np.tile([9.0, -9.0], 6)))  # seen, but not by the shorter
    stored = replace(kept(edge_map(0, 0), list(range(24))), landmarks=np.concatenate((places, others)))
    state.maps.put(0, stored)
    moved = np.where(np.arange(12)[:, None] < shown, places, places + np.array([0.0, 2.5]))
    drive = replace(kept(edge_map(9, 0), list(range(12))), landmarks=moved, terminal_x=6.0, path_length_m=6.0)
    assert on_one_way(state, edge, 0, drive, EXACT) == way


def test_too_few_landmarks_speak_neither_way() -> None:
    state = row()
    near = np.argsort(np.hypot(*edge_map(9, 77).landmarks.T))[:3].tolist()
    drive = replace(kept(edge_map(9, 77), near), terminal_x=6.0, path_length_m=6.0)
    assert on_one_way(state, state.graph.edges[0], 0, drive, EXACT)
    assert not on_one_way(state, state.graph.edges[0], 0, replace(edge_map(9, 77), terminal_x=6.0), EXACT)


def test_a_bad_homing_at_either_end_may_part_no_map() -> None:
    """0.2 m aside at the near end, 0.4 m along at the far one: several times what a meet point scatters."""
    state = row()
    edge = state.graph.edges[0]
    for drive in (
        replace(edge_map(9, 0), landmarks=edge_map(9, 0).landmarks - [0.2, 0.0]),
        replace(edge_map(9, 0), terminal_x=12.4),
    ):
        match = compare(state, edge, 0, drive, EXACT)
        assert match is not None
        assert match.agrees


def test_repeatability_is_that_of_the_kind_of_node() -> None:
    state = row()
    assert [retrace._repeat_m(state, node) for node in (0, 1)] == [0.3, 0.06]


def test_a_sight_faces_back_along_the_edge() -> None:
    """Come to a T along its stem: the branch come along lies ahead in the sight's frame, the others to its sides."""
    view = NodeView(NodeKind.MEET_POINT, 5.0, 1.0, 1.3, (0.5 + math.pi, 0.5 + math.pi / 2.0, 0.5 - math.pi / 2.0))
    drive = replace(edge_map(9, 0), arrival_heading=math.pi)  # back along x, as seen in the edge's frame
    sight = sight_of(GvgEvent(9, 0, EventKind.ARRIVAL, view, 0, 12.0), drive)
    assert sight.bearings == pytest.approx((0.0, -math.pi / 2.0, math.pi / 2.0))
    assert sight.edge_map is not None
    assert sight.edge_map.landmarks == pytest.approx(reverse(drive).landmarks)
    askew = sight_of(GvgEvent(9, 0, EventKind.ARRIVAL, view, 0, 12.0), replace(drive, arrival_heading=math.pi - 0.2))
    assert askew.bearings[0] == pytest.approx(-0.2)


def test_the_branch_departed_by_is_the_announced_one_unless_the_heading_says_another() -> None:
    node = row().graph.nodes[1]  # west, east, and 86 degrees
    view = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, (math.pi, 0.0, 1.5))
    assert branch_towards(node, math.radians(45.0), (0, 1, 2), 1, view) == 1
    assert branch_towards(node, math.radians(55.0), (0, 1, 2), 1, view) == 2
    assert branch_towards(node, -3.0, (0, 1, 2), 1, view) == 0


def test_a_visit_moves_a_bearing_by_its_share_and_counts_what_it_does_not_show() -> None:
    node = row().graph.nodes[1]
    node.visits += [(1, 1), (2, 2)]
    sight = Sight(NodeKind.MEET_POINT, 1.0, (0.2, 2.0), 0, None)
    assert observe(node, sight, SE2(0.0, 0.0, 0.1), CONFIG) == (1, 2)
    assert node.branches[1].bearing == pytest.approx(0.15)  # the second of two sightings: half way to 0.3
    assert node.branches[2].bearing == pytest.approx(1.8)
    assert [(branch.seen, branch.missed) for branch in node.branches.values()] == [(1, 1), (2, 0), (2, 0)]
    observe(node, Sight(NodeKind.MEET_POINT, 1.0, (-1.5,), 0, None), SE2(), CONFIG)
    assert (node.branches[3].seen, node.branches[3].missed) == (1, 2)  # the visits before had not shown it
