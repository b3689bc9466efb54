"""Known answers of what speaks for "this is that node": pose, view, constellation, and how often places look alike."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scripted_level import edge_map, row

from hslam_atlas import hypothesis
from hslam_atlas.alignment import Alignment
from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import Node
from hslam_atlas.hypothesis import (
    Sight,
    _pose_evidence,
    _starts,
    align_branches,
    best_constellation,
    is_where,
    learn_look_alikes,
    view_evidence,
    weigh,
)
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.map_match import MapMatch
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

CONFIG = AtlasConfig()
NOWHERE = SE2(3.0, 0.0, 0.0)
WIDE = UncertainPose.diagonal(SE2(), 2.0, 0.1)
MIDDLE = (math.pi, 0.0, 1.5)


def sight(bearings: tuple[float, ...] = (0.0, 2.0, -2.0), kind: NodeKind = NodeKind.MEET_POINT) -> Sight:
    return Sight(kind, 1.0, bearings, 0, None)


def node(clearance_m: float = 1.0) -> Node:
    found = Node(0, NodeKind.MEET_POINT, clearance_m)
    for bearing in (0.0, 2.0, -2.0):
        found.add_branch(bearing)
    return found


def match(evidence: float, *, agrees: bool) -> MapMatch:
    empty = np.zeros((0, 0))
    alignment = Alignment(SE2(), np.eye(3), (), 0.0, 1, evidence, 0.1, np.zeros(3), empty, empty)
    return MapMatch(alignment, evidence, 1.0, agrees)


@pytest.mark.parametrize(("clearance_m", "evidence"), [(1.0, 0.5), (1.3, 0.0), (0.7, 0.0), (1.6, -1.5), (9.0, -3.5)])
def test_a_clearance_read_otherwise_speaks_against_a_node_but_only_so_much(clearance_m: float, evidence: float) -> None:
    assert view_evidence(node(clearance_m), sight()) == pytest.approx(evidence)


@pytest.mark.parametrize(
    ("seen", "evidence"),
    [
        (sight((0.0, 2.0)), -2.5),
        (sight((0.0, 1.0, 2.0, -2.0)), -2.5),
        (sight((0.0,)), -8.0),
        (sight(kind=NodeKind.BOUNDARY_POINT), -8.0),
    ],
)
def test_one_branch_more_or_less_is_forgiven_at_a_price_and_two_or_another_kind_are_not(
    seen: Sight, evidence: float
) -> None:
    assert view_evidence(node(), seen) == pytest.approx(evidence)


@pytest.mark.parametrize("away_m", [0.0, 3.0])
def test_a_pose_is_worth_its_density_over_that_of_nodes(away_m: float) -> None:
    """2 m by the chain, half as much again for optimism, and a meet point that scatters by 6 cm in both visits."""
    variance = (1.5 * 2.0) ** 2 + 2.0 * 0.06**2
    expected = -0.5 * away_m**2 / variance - math.log(2.0 * math.pi * variance) - math.log(CONFIG.node_density)
    pose = UncertainPose(SE2(0.0, away_m, 0.0), WIDE.covariance)
    assert _pose_evidence(pose, 0.0, CONFIG) == pytest.approx(expected)


def test_no_pose_is_worth_more_than_six_nats() -> None:
    assert _pose_evidence(UncertainPose.exact(SE2()), 0.0, CONFIG) == pytest.approx(6.0)


@pytest.mark.parametrize(("away_m", "known"), [(0.339, True), (0.340, False)])
def test_beyond_the_gate_a_node_is_another(away_m: float, known: bool) -> None:
    """Four standard deviations of two meet points."""
    assert (_pose_evidence(UncertainPose.exact(SE2(away_m, 0.0, 0.0)), 0.0, CONFIG) is not None) == known


def test_hardly_a_second_node_has_a_free_disc_that_overlaps() -> None:
    sure, unsure = UncertainPose.exact(SE2()), WIDE
    assert _pose_evidence(sure, 2.0, CONFIG) == pytest.approx(6.0 - math.log(0.02))
    bare = _pose_evidence(unsure, 0.0, CONFIG)
    assert bare is not None
    outside = math.exp(-0.5 * 4.0 / (9.0 + 0.0072))
    assert _pose_evidence(unsure, 2.0, CONFIG) == pytest.approx(bare - math.log(0.02 + 0.98 * outside))


@pytest.mark.parametrize(
    ("kind", "away_m", "there"),
    [
        (NodeKind.MEET_POINT, 0.257, True),
        (NodeKind.MEET_POINT, 0.258, False),
        (NodeKind.BOUNDARY_POINT, 1.286, True),
        (NodeKind.BOUNDARY_POINT, 1.287, False),
    ],
)
def test_a_sight_is_where_a_node_is_as_well_as_its_kind_repeats(kind: NodeKind, away_m: float, there: bool) -> None:
    """The gate of 9.2 over twice the variance: once for the node, once for the sight."""
    assert is_where(Node(0, kind, 1.0), UncertainPose.exact(SE2(away_m, 0.0, 0.0)), CONFIG) == there


def test_the_unsurer_a_heading_the_more_starts_within_two_deviations_and_60_degrees() -> None:
    degrees = [[round(math.degrees(start)) for start in _starts(math.radians(std))] for std in (2.0, 6.5, 60.0)]
    assert degrees[:2] == [[0], [0, -6, 6, -12, 12]]
    assert 50 < max(degrees[2]) <= 60


def test_branches_are_compared_in_the_frame_of_the_node() -> None:
    assert align_branches(node(), sight((-0.5, 1.5, -2.5)), SE2(0.0, 0.0, 0.5), CONFIG) == (0, 1, 2)
    assert align_branches(node(), sight((-2.0, 0.0, 2.0)), SE2(0.0, 0.0, 2.0), CONFIG) == (0, 1, 2)


@pytest.mark.parametrize(
    ("found", "std_m", "credible"),
    [
        pytest.param(match(5.0, agrees=True), 2.0, True, id="a constellation matches"),
        pytest.param(match(5.0, agrees=False), 2.0, False, id="none matches, the pose is unsure"),
        pytest.param(match(5.0, agrees=False), 0.0, True, id="none matches, the pose leaves no other"),
        pytest.param(match(-5.0, agrees=False), 0.0, False, id="a constellation speaks against it"),
        pytest.param(match(-5.0, agrees=True), 2.0, True, id="many pairs, yet against it"),
        pytest.param(None, 0.0, True, id="no map, the pose leaves no other"),
        pytest.param(None, 2.0, False, id="no map, the pose is unsure"),
    ],
)
def test_what_makes_a_hypothesis_credible(
    found: MapMatch | None, std_m: float, credible: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = row()
    pose = UncertainPose.diagonal(SE2(), std_m, 0.1)
    monkeypatch.setattr(hypothesis, "best_constellation", lambda *_: (found, pose))
    h = weigh(state.graph, state.maps, node(), sight(), pose, state.look_alikes, CONFIG)
    assert h is not None
    assert h.credible == credible
    maps = 0.0 if found is None else state.look_alikes.joint([found.evidence])
    assert h.evidence == pytest.approx(h.place_evidence + maps)


def test_the_smaller_free_disc_is_the_one_that_excludes(monkeypatch: pytest.MonkeyPatch) -> None:
    state = row()
    monkeypatch.setattr(hypothesis, "best_constellation", lambda *_: (None, UncertainPose.exact(SE2())))
    discs = [
        weigh(state.graph, state.maps, node(a), replace(sight(), clearance_m=b), WIDE, state.look_alikes, CONFIG)
        for a, b in ((1.0, 1.0), (5.0, 1.0), (1.0, 5.0))
    ]
    place = [h.place_evidence for h in discs if h]
    assert place[1:] == pytest.approx([place[0] - 4.0] * 2)  # by the clearances' difference alone


def test_the_constellation_that_fits_best_says_where_the_sight_is() -> None:
    """Of the two corridors that meet in node 1 the sight shows the second's landmarks, from 0.1 m beside the node."""
    state = row()
    middle = state.graph.nodes[1]
    seen = edge_map(9, 1)
    moved = replace(seen, landmarks=seen.landmarks - [0.1, -0.05])
    as_departed = Sight(NodeKind.MEET_POINT, 1.0, MIDDLE, 0, moved)
    found, pose = best_constellation(
        state.graph, state.maps, middle, as_departed, UncertainPose.diagonal(SE2(), 0.1, 0.02), CONFIG
    )
    assert found is not None
    assert found.agrees
    assert found.evidence > 10.0
    assert (pose.pose.x, pose.pose.y) == pytest.approx((0.1, -0.05), abs=0.02)
    assert pose.heading_std() > CONFIG.heading_floor


@pytest.mark.parametrize(("known", "alike"), [(1, True), (0, False)])
def test_nodes_that_cannot_be_the_sight_tell_how_much_places_look_alike(known: int, alike: bool) -> None:
    """Corridor 0 seen again from its far end, 40 m off: node 1 looks the same, node 0 does not."""
    state = row()
    seen = Sight(state.graph.nodes[known].kind, 1.0, MIDDLE, 0, reverse(edge_map(9, 0)))
    far_off = UncertainPose.diagonal(SE2(40.0, 0.0, math.pi), 1.0, 0.05)
    learn_look_alikes(state.graph, state.maps, [(state.graph.nodes[known], far_off)], seen, state.look_alikes, CONFIG)
    assert (state.look_alikes.compared, state.look_alikes.alike) == (1, int(alike))


def test_a_node_that_may_be_the_sight_tells_nothing_of_look_alikes() -> None:
    """Within the gate at twice the deviation of the chain, though not at once."""
    state = row()
    seen = Sight(NodeKind.MEET_POINT, 1.0, MIDDLE, 0, reverse(edge_map(9, 0)))
    alike = LookAlikes(1e-4)
    pose = UncertainPose.diagonal(SE2(9.0, 0.0, 0.0), 1.0, 0.05)  # 6 deviations by 1.5 m, 3 by 3 m
    learn_look_alikes(state.graph, state.maps, [(state.graph.nodes[1], pose)], seen, alike, CONFIG)
    assert alike.compared == 0
