"""Every pair of conversions, through CDR, on arbitrary values."""

import math
from dataclasses import replace

import numpy as np
import pytest
from broken_messages import through_cdr
from geometry_msgs.msg import Pose2D
from hypothesis import given
from hypothesis import strategies as st

from hslam_ros import conversions
from hslam_ros.stamps import stamp_from_msg, stamp_to_msg
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import (
    SCOUT_RING,
    FieldOfView,
    LandmarkSighting,
    LandmarkView,
    OdometrySample,
    PlanarCovariance,
    SonarPing,
    SonarSweep,
    Velocity,
)

stamps = st.integers(0, 2**31 * 10**9 - 1)
metres = st.floats(-1e4, 1e4)
angles = st.floats(-math.pi, math.pi, exclude_max=True)
poses = st.builds(SE2, metres, metres, angles)


@given(stamps)
def test_stamps_are_exact(stamp_ns: int) -> None:
    assert stamp_from_msg(through_cdr(stamp_to_msg(stamp_ns))) == stamp_ns


given_covariances = st.none() | st.builds(PlanarCovariance, *[metres] * 6).filter(any)


@given(
    st.builds(OdometrySample, stamps, poses, st.builds(Velocity, metres, metres), given_covariances, given_covariances)
)
def test_odometry_keeps_all_but_the_last_bits_of_the_heading(sample: OdometrySample) -> None:
    once = conversions.odometry_from_msg(conversions.odometry_to_msg(sample))
    assert once == conversions.odometry_from_msg(through_cdr(conversions.odometry_to_msg(sample)))
    assert replace(once, base_in_odom=sample.base_in_odom) == sample
    assert once.base_in_odom[:2] == sample.base_in_odom[:2]
    assert abs(wrap(once.base_in_odom.theta - sample.base_in_odom.theta)) < 1e-12


def test_a_covariance_of_odometry_is_taken_from_both_its_places_and_none_is_refused_for_it() -> None:
    msg = conversions.odometry_to_msg(OdometrySample(0, SE2()))
    assert conversions.odometry_from_msg(msg) == OdometrySample(0, SE2())
    msg.twist.covariance = np.arange(36.0)
    msg.pose.covariance[35] = math.nan
    sample = conversions.odometry_from_msg(through_cdr(msg))
    assert sample.twist_covariance == PlanarCovariance(xx=0.0, xy=1.0, xt=5.0, yy=7.0, yt=11.0, tt=35.0)
    assert sample.pose_covariance is not None
    assert math.isnan(sample.pose_covariance.tt)
    both = PlanarCovariance(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    full = conversions.odometry_to_msg(OdometrySample(0, SE2(), Velocity(), both)).twist.covariance.reshape(6, 6)
    assert np.array_equal(full, full.T)
    assert np.array_equal(full[np.ix_((0, 1, 5), (0, 1, 5))], both.matrix)


@given(poses)
def test_poses_are_exact(pose: SE2) -> None:
    assert conversions.pose_from_msg(through_cdr(conversions.pose_to_msg(pose))) == pose


@given(st.builds(Velocity, metres, metres), stamps)
def test_commands_are_exact(velocity: Velocity, stamp_ns: int) -> None:
    msg = through_cdr(conversions.velocity_to_msg(velocity, stamp_ns))
    assert conversions.velocity_from_msg(msg) == velocity
    assert stamp_from_msg(msg.header.stamp) == stamp_ns


pings = st.builds(SonarPing, st.integers(0, 15), stamps, st.floats(0.1, 7.0) | st.just(math.inf))


@given(stamps, st.lists(pings, max_size=8).map(tuple))
def test_sonar_is_exact(stamp_ns: int, heard: tuple[SonarPing, ...]) -> None:
    sweep = SonarSweep(stamp_ns, SCOUT_RING, heard)
    assert conversions.sonar_from_msg(through_cdr(conversions.sonar_to_msg(sweep))) == sweep


positive = st.floats(0.0, 100.0)
deviations = st.floats(1e-4, 6.0)
sightings = st.builds(LandmarkSighting, st.floats(0.001, 100.0), angles, deviations, deviations)


fields_of_view = st.builds(FieldOfView, *[st.floats(-10.0, 10.0)] * 4, positive)


@given(st.builds(LandmarkView, stamps, positive, st.lists(sightings, max_size=12).map(tuple), fields_of_view))
def test_landmarks_are_exact(view: LandmarkView) -> None:
    assert conversions.landmarks_from_msg(through_cdr(conversions.landmarks_to_msg(view))) == view


nodes = st.builds(
    NodeView, st.sampled_from(NodeKind), metres, metres, positive, st.lists(angles, min_size=1, max_size=5).map(tuple)
)


@st.composite
def events(draw: st.DrawFn) -> GvgEvent:
    """Return an event that has what its kind must have."""
    kind = draw(st.sampled_from(EventKind))
    node, branch = None, -1
    if kind in (EventKind.DEPARTURE, EventKind.ARRIVAL):
        node = draw(nodes)
        branch = draw(st.integers(-1 if kind is EventKind.ARRIVAL else 0, node.degree - 1))
    return GvgEvent(draw(st.integers(0, 2**63)), draw(stamps), kind, node, branch, draw(positive))


@given(events())
def test_events_are_exact(event: GvgEvent) -> None:
    assert conversions.event_from_msg(through_cdr(conversions.event_to_msg(event))) == event


@pytest.mark.parametrize("count", [0, 1, 7])
def test_edge_maps_are_exact(count: int) -> None:
    rng = np.random.default_rng(count)
    spread = rng.normal(size=(2 + 2 * count, 2 + 2 * count))
    edge_map = EdgeMap(
        traversal=3,
        arrival=4,
        terminal_x=12.5,
        landmarks=rng.normal(size=(count, 2)),
        covariance=spread @ spread.T,
        sightings=tuple(range(count)),
        departure_heading=0.1,
        arrival_heading=-0.2,
        robot_at_arrival=SE2(12.4, 0.1, -0.3),
        path_length_m=13.0,
    )
    back = conversions.edge_map_from_msg(through_cdr(conversions.edge_map_to_msg(edge_map, 77)))
    for name in EdgeMap.__dataclass_fields__:
        assert np.array_equal(getattr(back, name), getattr(edge_map, name)), name


def test_links_are_exact() -> None:
    link = FrameLink(5, 6, SE2(1.0, 2.0, 3.0), np.diag([1.0, 0.1, 0.0]) + 0.01)
    back = conversions.link_from_msg(through_cdr(conversions.link_to_msg(link, 88)))
    assert (back.traversal, back.departure, back.departure_in_edge) == (5, 6, SE2(1.0, 2.0, 3.0))
    assert np.array_equal(back.covariance, link.covariance)


def test_a_quaternion_is_a_heading_on_both_sides_of_pi() -> None:
    for yaw in (-math.pi, -1.0, 0.0, 2.0, math.pi):
        assert abs(wrap(conversions.yaw_from_quaternion(conversions.yaw_to_quaternion(yaw)) - yaw)) < 1e-12
    assert isinstance(conversions.pose_to_msg(SE2()), Pose2D)
