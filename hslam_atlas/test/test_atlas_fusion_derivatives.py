"""Fusion's derivatives against differences, and what a turn of the frame must leave where it is."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scripted_level import LENGTH_M, edge_map, row

from hslam_atlas.alignment import Alignment
from hslam_atlas.fusion import _joined, _turned, fuse
from hslam_atlas.map_match import MapMatch
from hslam_atlas.retrace import far_end, far_sight_in_node, update
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.se2 import SE2, Array

ASIDE = 0.08
"""How far to the left the far meet point proves to lie (rad)."""


def spread(size: int, rng: np.random.Generator) -> Array:
    """Return a covariance with every correlation."""
    root = rng.normal(size=(size, size))
    covariance: Array = root @ root.T
    return covariance


def derivative(function: Callable[[Array], Array], at: Array) -> Array:
    """Return a function's Jacobian by differences."""
    step = 1e-6
    ways = [np.eye(len(at))[n] * step for n in range(len(at))]
    return np.column_stack([(function(at + way) - function(at - way)) / (2.0 * step) for way in ways])


def outcome(existing: EdgeMap, candidate: EdgeMap, pairs: tuple[tuple[int, int], ...], offset: SE2) -> Alignment:
    """Return an alignment by which the far meet point lies aside, with an arbitrary posterior."""
    maps = [np.concatenate(([[m.terminal_x, 0.0]], m.landmarks)).ravel() for m in (existing, candidate)]
    mean = np.concatenate((np.array(offset), *maps))
    x = existing.terminal_x
    mean[3:5] = [x * math.cos(ASIDE), x * math.sin(ASIDE)]
    prior = 1e-4 * spread(len(mean), np.random.default_rng(3))
    return Alignment(offset, prior[:3, :3], pairs, 1.0, 2 * len(pairs), 9.0, 0.1, mean, prior, np.zeros((len(mean), 0)))


def few(traversal: int, places: tuple[tuple[float, float], ...]) -> EdgeMap:
    """Return a map of a few landmarks."""
    size = 2 + 2 * len(places)
    covariance = 1e-4 * np.eye(size)
    covariance[1, 1] = 0.0
    return replace(
        edge_map(traversal, 0), landmarks=np.array(places), covariance=covariance, sightings=(30,) * len(places),
        departure_heading=0.1, arrival_heading=math.pi - 0.2,
    )  # fmt: skip


OLD, NEW = few(0, ((2.0, 1.0), (6.0, -1.0))), few(7, ((2.0, 1.0), (9.0, 1.0)))


@pytest.mark.parametrize("terminal", [(8.0, 0.4), (-3.0, 2.0)])
def test_the_turn_moves_the_spread_as_it_moves_the_points(terminal: tuple[float, float]) -> None:
    places = np.array([terminal, (1.0, 2.0), (-4.0, 0.5)])
    before = spread(6, np.random.default_rng(1))
    jacobian = derivative(lambda x: _turned(x.reshape(-1, 2), np.eye(6))[0].ravel(), places.ravel())
    turned, after, phi = _turned(places, before)
    assert after == pytest.approx(jacobian @ before @ jacobian.T, abs=1e-5)
    assert phi == pytest.approx(math.atan2(terminal[1], terminal[0]))
    assert turned[0] == pytest.approx((math.hypot(*terminal), 0.0))
    assert turned[1] == pytest.approx(SE2(0.0, 0.0, phi).inverse().apply(1.0, 2.0))


def test_what_only_the_new_drive_saw_is_placed_by_the_offset_and_spread_by_it() -> None:
    found = outcome(OLD, NEW, ((0, 0),), SE2(0.3, -0.2, 0.5))

    def joined(mean: Array) -> Array:
        offset = SE2(*mean[:3].tolist())
        return _joined(OLD, NEW, replace(found, mean=mean, offset=offset))[0].ravel()

    points, covariance = _joined(OLD, NEW, found)
    assert len(points) == 4
    assert points[3] == pytest.approx(found.offset.apply(9.0, 1.0))
    jacobian = derivative(joined, found.mean)
    assert covariance == pytest.approx(jacobian @ found.prior_covariance @ jacobian.T, abs=1e-8)


def test_directions_turn_with_the_frame() -> None:
    """A landmark straight ahead at departure stays straight ahead, however the frame is laid anew."""
    ahead = few(0, tuple((d * math.cos(0.1), d * math.sin(0.1)) for d in (2.0, 6.0)))
    updated, turn = fuse(ahead, NEW, outcome(ahead, NEW, (), SE2()), (1, 1), forget_below=0)
    assert turn == pytest.approx(ASIDE)
    assert updated.departure_heading == pytest.approx(math.atan2(*updated.landmarks[0][::-1].tolist()))
    assert updated.departure_heading == pytest.approx(0.1 - ASIDE)
    assert updated.arrival_heading == pytest.approx(ahead.arrival_heading - ASIDE)


def test_an_unseen_landmark_keeps_a_third_of_its_sightings() -> None:
    updated, _ = fuse(OLD, NEW, outcome(OLD, NEW, ((0, 0),), SE2()), (1, 1), forget_below=1)
    assert updated.sightings == (60, 10, 30)


@pytest.mark.parametrize("end", [0, 1])
def test_landmarks_stay_where_they_are_in_both_nodes(end: int) -> None:
    """The frame turns, and each end's pose of it in its node turns against that."""
    state = row()
    first, second = state.graph.edges[1].ends
    bent = (
        first._replace(frame_in_node=UncertainPose.exact(SE2(0.1, 0.2, 0.3))),
        second._replace(frame_in_node=UncertainPose.exact(SE2(-0.2, 0.1, 2.0))),
    )
    edge = replace(state.graph.edges[1], ends=bent)
    state.graph.put_edge(edge)
    state.maps.put(1, OLD if end == 0 else reverse(OLD))
    found = outcome(OLD, NEW, ((0, 0),), SE2())
    match = MapMatch(found, 20.0, 1.0, agrees=True)
    expected = found.mean[5:9].reshape(-1, 2)
    near, far = edge.ends[end].frame_in_node.pose, edge.ends[1 - end].frame_in_node.pose
    in_near, in_far = near.apply_all(expected), (far @ SE2(LENGTH_M, 0.0, math.pi).inverse()).apply_all(expected)
    after = update(state, edge, end, NEW, match)
    assert after.traversals == (1, 7)
    seen = [state.maps.seen_from(1, side).landmarks for side in (end, 1 - end)]
    frames = [after.ends[side].frame_in_node.pose for side in (end, 1 - end)]
    assert frames[0].apply_all(seen[0])[:2] == pytest.approx(in_near, abs=1e-9)
    assert frames[1].apply_all(seen[1])[:2] == pytest.approx(in_far, abs=1e-9)


def test_no_drive_is_fused_twice() -> None:
    state = row()
    edge = state.graph.edges[1]
    match = MapMatch(outcome(OLD, NEW, ((0, 0),), SE2()), 20.0, 1.0, agrees=True)
    again = replace(edge, traversals=(1, 7))
    assert update(state, again, 0, NEW, match) is again
    assert update(state, edge, 0, NEW, replace(match, agrees=False)) is edge


def test_where_a_drive_along_a_known_edge_ends_in_the_far_node() -> None:
    """A drive whose frame lies 0.2 m ahead and a little turned, and whose far end is as far short of the edge's."""
    state = row()
    edge = state.graph.edges[0]
    offset = SE2(0.2, 0.05, 0.02)
    match = MapMatch(replace(outcome(OLD, NEW, ((0, 0),), offset)), 20.0, 1.0, agrees=True)
    short = replace(NEW, terminal_x=LENGTH_M - 0.3)
    sight = far_sight_in_node(edge, 0, short, match)
    assert sight.pose == pytest.approx(SE2(LENGTH_M, 0.0, 0.0).inverse() @ offset @ far_end(short).pose, abs=1e-9)
    assert sight.pose.x == pytest.approx(-0.1, abs=0.01)
