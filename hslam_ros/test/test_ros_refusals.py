"""Whatever comes, a conversion gives numbers that can be reckoned with, or refuses by name."""

import math
from array import array
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
from broken_messages import broken
from hslam_msgs.msg import NodeStatus
from hypothesis import given
from hypothesis import strategies as st

from hslam_ros import conversions
from hslam_ros.checks import COVARIANCE_TOLERANCE, FARTHEST_M, LARGEST, LEAST_STD
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.errors import MessageError
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2
from hslam_types.sensing import (
    SCOUT_RING,
    LandmarkSighting,
    LandmarkView,
    OdometrySample,
    PlanarCovariance,
    SonarPing,
    SonarSweep,
    Velocity,
)

NODE = NodeView(NodeKind.MEET_POINT, 1.0, 2.0, 0.8, (0.0, 2.0, -2.0))
ARRIVAL = conversions.event_to_msg(GvgEvent(4, 10**9, EventKind.ARRIVAL, NODE, 1, 7.0))
ODOMETRY = conversions.odometry_to_msg(OdometrySample(10**9, SE2(1.0, 2.0, 3.0), Velocity(0.3, 0.1)))
SONAR = conversions.sonar_to_msg(
    SonarSweep(10**9, SCOUT_RING, (SonarPing(3, 9 * 10**8, 1.5), SonarPing(15, 10**9, math.inf)))
)
LANDMARKS = conversions.landmarks_to_msg(
    LandmarkView(10**9, 5.0, (LandmarkSighting(2.0, 0.5, 0.05, 0.02), LandmarkSighting(4.0, -2.0, 0.08, 0.02)))
)
EDGE_MAP = conversions.edge_map_to_msg(
    EdgeMap(3, 4, 7.0, np.array([[1.0, 1.0], [3.0, -1.0]]), np.eye(6), (5, 6), 0.1, 3.0, SE2(7.0, 0.0, 0.1), 7.1), 10**9
)
LINK = conversions.link_to_msg(FrameLink(3, 5, SE2(7.0, 0.1, 1.0), np.diag([0.01, 0.02, 0.003])), 10**9)
INPUTS: dict[str, tuple[Callable[[Any], Any], Any]] = {
    "odometry": (conversions.odometry_from_msg, ODOMETRY),
    "command": (conversions.velocity_from_msg, conversions.velocity_to_msg(Velocity(0.3, 0.1), 10**9)),
    "sonar": (conversions.sonar_from_msg, SONAR),
    "landmarks": (conversions.landmarks_from_msg, LANDMARKS),
    "event": (conversions.event_from_msg, ARRIVAL),
    "edge-map": (conversions.edge_map_from_msg, EDGE_MAP),
    "link": (conversions.link_from_msg, LINK),
    "status": (conversions.answer_from_msg, NodeStatus(header=conversions.header(10**9, ""), node="gvg", outputs=3)),
}


def real_numbers(value: Any) -> Iterator[float]:
    """Yield every real number in a value, but of odometry's covariances, which whoever weighs it believes or not."""
    if isinstance(value, PlanarCovariance):
        return
    if isinstance(value, float):
        yield value
    elif isinstance(value, np.ndarray):
        yield from value.ravel().tolist()
    elif isinstance(value, tuple):
        for item in value:
            yield from real_numbers(item)
    elif is_dataclass(value):
        for field in fields(value):
            yield from real_numbers(getattr(value, field.name))


def assert_sane(value: Any) -> None:
    """Check what the algorithms rely on."""
    assert all(abs(number) <= LARGEST**2 or number == math.inf for number in real_numbers(value))
    stamp_ns = getattr(value, "stamp_ns", 0)
    assert 0 <= stamp_ns < 2**62
    if isinstance(value, SonarSweep):
        assert all(ping.sensor < len(value.ring.bearings) for ping in value.pings)
        assert all(ping.stamp_ns >= 0 and ping.range_m >= 0.0 for ping in value.pings)
    elif math.inf in real_numbers(value):
        pytest.fail("only an echo may be missing")
    if isinstance(value, LandmarkView):
        assert all(0.0 < s.range_m <= FARTHEST_M for s in value.sightings)
        assert all(min(s.range_std_m, s.bearing_std) >= LEAST_STD for s in value.sightings)
    if isinstance(value, GvgEvent) and value.kind in (EventKind.DEPARTURE, EventKind.ARRIVAL):
        assert value.node is not None
        assert (0 if value.kind is EventKind.DEPARTURE else -1) <= value.branch < value.node.degree
    if isinstance(value, EdgeMap):
        assert value.size == len(value.sightings)
        assert len(value.covariance) == 2 + 2 * value.size
    if isinstance(value, EdgeMap | FrameLink):
        largest = np.abs(value.covariance).max()
        assert np.allclose(value.covariance, value.covariance.T, rtol=0.0, atol=COVARIANCE_TOLERANCE * largest)
        assert np.linalg.eigvalsh(value.covariance)[0] >= -COVARIANCE_TOLERANCE * largest


@pytest.mark.parametrize("name", INPUTS)
@given(data=st.data())
def test_a_conversion_gives_what_can_be_reckoned_with_or_refuses(name: str, data: st.DataObject) -> None:
    convert, good = INPUTS[name]
    assert_sane(convert(good))
    try:
        value = convert(data.draw(broken(good)))
    except MessageError:
        return
    assert_sane(value)


def changed(msg: Any, **values: Any) -> Any:
    """Return a copy of a message with fields, dots written as double underscores, replaced."""
    again = deepcopy(msg)
    for path, value in values.items():
        *owners, name = path.split("__")
        owner = again
        for step in owners:
            owner = getattr(owner, step)
        setattr(owner, name, value)
    return again


@pytest.mark.parametrize(
    ("name", "change", "told"),
    [
        ("odometry", {"header__stamp__sec": -1}, "header.stamp"),
        ("odometry", {"header__stamp__nanosec": 10**9}, "header.stamp"),
        ("odometry", {"pose__pose__position__x": math.nan}, "pose.pose.position.x = nan"),
        ("odometry", {"pose__pose__position__y": math.inf}, "pose.pose.position.y = inf"),
        ("odometry", {"pose__pose__orientation__w": 0.0, "pose__pose__orientation__z": 0.0}, "norm"),
        ("odometry", {"twist__twist__linear__x": math.nan}, "twist.twist.linear.x"),
        ("odometry", {"twist__twist__angular__z": -math.inf}, "twist.twist.angular.z"),
        ("command", {"twist__linear__x": math.nan}, "twist.linear.x"),
        ("command", {"twist__angular__z": math.inf}, "twist.angular.z"),
        ("sonar", {"sensor": array("B", [3])}, "sensor 1, stamps 2, ranges 2"),
        ("sonar", {"sensor": array("B", [3, 16])}, "sensor = 16 is no index of 16"),
        ("sonar", {"ranges": array("d", [1.0, math.nan])}, "ranges"),
        ("sonar", {"ranges": array("d", [1.0, -math.inf])}, "ranges"),
        ("sonar", {"range_max": 0.1}, "range_max"),
        ("sonar", {"bearings": array("d", [math.nan] * 16)}, r"bearings\[0\]"),
        ("sonar", {"mount_radius": -0.2}, "mount_radius"),
        ("landmarks", {"ranges": array("d", [2.0])}, "ranges 1, bearings 2"),
        ("landmarks", {"range_stds": array("d", [0.05, 0.0])}, r"range_stds\[1\] = 0"),
        ("landmarks", {"bearing_stds": array("d", [-0.02, 0.02])}, r"bearing_stds\[0\]"),
        ("landmarks", {"bearings": array("d", [0.1, math.inf])}, r"bearings\[1\]"),
        ("landmarks", {"range_max": math.inf}, "range_max"),
        ("event", {"kind": 99}, "kind = 99 is unknown"),
        ("event", {"node__kind": 0}, "node.kind = 0 is unknown"),
        ("event", {"has_node": False}, "arrival without a node"),
        ("event", {"node__bearings": array("d")}, "arrival without a node"),
        ("event", {"branch": 3}, "branch = 3"),
        ("event", {"branch": -2}, "branch = -2"),
        ("event", {"kind": 2, "branch": -1}, "branch = -1"),
        ("event", {"path_length": math.nan}, "path_length"),
        ("event", {"node__clearance": -1.0}, "node.clearance"),
        ("edge-map", {"landmarks": array("d", [1.0, 1.0, 3.0])}, "x 2, y 1"),
        ("edge-map", {"sightings": array("I", [5])}, "sightings 1"),
        ("edge-map", {"covariance": array("d", np.eye(5).ravel())}, "25 entries, not 6 x 6"),
        ("edge-map", {"covariance": array("d", np.diag([1.0, 1, 1, 1, 1, -1e-3]).ravel())}, "semi-definite"),
        ("edge-map", {"covariance": array("d", np.triu(np.ones((6, 6))).ravel())}, "symmetric"),
        ("edge-map", {"covariance": array("d", np.full(36, math.nan))}, "covariance"),
        ("edge-map", {"robot_at_arrival__theta": math.nan}, "robot_at_arrival.theta"),
        ("link", {"covariance": np.full(9, math.inf)}, "covariance"),
        ("link", {"departure_in_edge__x": math.nan}, "departure_in_edge.x"),
        ("status", {"header__stamp__sec": -5}, "header.stamp"),
    ],
)
def test_what_is_refused_is_named(name: str, change: dict[str, Any], told: str) -> None:
    convert, good = INPUTS[name]
    with pytest.raises(MessageError, match=told):
        convert(changed(good, **change))


def test_rounding_is_no_contradiction() -> None:
    """Maps as a filter makes them are symmetric and positive up to the last bits; the terminal has no y."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(42, 30))
    root[1] = 0.0
    spread = root @ root.T + 1e-14 * rng.normal(size=(42, 42))
    edge_map = EdgeMap(3, 4, 7.0, rng.normal(size=(20, 2)), spread, (5,) * 20, 0.1, 3.0, SE2(), 7.1)
    assert np.array_equal(conversions.edge_map_from_msg(conversions.edge_map_to_msg(edge_map, 0)).covariance, spread)
