"""Every conversion between the suite's values and its messages, in pairs.

All of them are exact (float64 throughout) but for the heading of an odometry message, which passes
through a quaternion; whoever needs the same bits with and without ROS in between sends it through
the pair once.

What comes out of a message has been checked: each ``x_from_msg`` raises MessageError, naming the field, on what is no
number, out of all bounds (`checks`) or contradicts itself. Fields that the suite does not use are not looked at.
"""

import math
from array import array

import numpy as np
from geometry_msgs.msg import Pose, Pose2D, PoseWithCovariance, Quaternion, Twist, TwistStamped, TwistWithCovariance
from hslam_msgs.msg import EdgeMap as EdgeMapMsg
from hslam_msgs.msg import FrameLink as FrameLinkMsg
from hslam_msgs.msg import GvgEvent as GvgEventMsg
from hslam_msgs.msg import GvgNode as GvgNodeMsg
from hslam_msgs.msg import LandmarkObservations, NodeStatus
from hslam_msgs.msg import SonarRing as SonarRingMsg
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from hslam_ros.checks import (
    FARTHEST_M,
    LEAST_RANGE_M,
    LEAST_STD,
    covariance,
    echo,
    index,
    kind_of,
    number,
    numbers,
    rotation,
    same_length,
    stamp,
)
from hslam_ros.stamps import stamp_to_msg
from hslam_types.answer import Answer
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.errors import MessageError
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2
from hslam_types.sensing import (
    FieldOfView,
    LandmarkSighting,
    LandmarkView,
    OdometrySample,
    PlanarCovariance,
    SonarPing,
    SonarRing,
    SonarSweep,
    Velocity,
)

_PLANAR = (0, 1, 5, 7, 11, 35)
"""Where a 6 x 6 covariance, row-major over x, y, z and the turns about them (REP-103), has that of x, y and yaw."""
_MIRRORED = (0, 6, 30, 7, 31, 35)
"""The same entries below the diagonal."""


def header(stamp_ns: int, frame_id: str) -> Header:
    """Return a header for a stamp in nanoseconds."""
    return Header(stamp=stamp_to_msg(stamp_ns), frame_id=frame_id)


def yaw_to_quaternion(yaw: float) -> Quaternion:
    """Return the rotation by ``yaw`` (rad) about z."""
    return Quaternion(z=math.sin(yaw / 2.0), w=math.cos(yaw / 2.0))


def yaw_from_quaternion(q: Quaternion) -> float:
    """Return the heading (rad, in (-pi, pi]) of a rotation about z; roll and pitch are ignored."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def pose_to_msg(pose: SE2) -> Pose2D:
    """Return a planar pose as a message."""
    return Pose2D(x=pose.x, y=pose.y, theta=pose.theta)


def pose_from_msg(msg: Pose2D, field: str = "pose") -> SE2:
    """Return a message's planar pose."""
    return SE2(number(msg.x, f"{field}.x"), number(msg.y, f"{field}.y"), number(msg.theta, f"{field}.theta"))


def pose_in_plane(msg: Pose, field: str = "pose") -> SE2:
    """Return what of a pose in space is in the plane of the floor."""
    x, y = number(msg.position.x, f"{field}.position.x"), number(msg.position.y, f"{field}.position.y")
    return SE2(x, y, rotation(msg.orientation, f"{field}.orientation"))


def odometry_to_msg(sample: OdometrySample, parent: str = "odom", child: str = "base_link") -> Odometry:
    """Return odometry as a message: the pose of ``child`` in ``parent``."""
    msg = Odometry(header=header(sample.stamp_ns, parent), child_frame_id=child)
    msg.pose.pose.position.x = sample.base_in_odom.x
    msg.pose.pose.position.y = sample.base_in_odom.y
    msg.pose.pose.orientation = yaw_to_quaternion(sample.base_in_odom.theta)
    msg.twist.twist.linear.x = sample.velocity.forward
    msg.twist.twist.angular.z = sample.velocity.turn
    _put_covariance(msg.pose, sample.pose_covariance)
    _put_covariance(msg.twist, sample.twist_covariance)
    return msg


def odometry_from_msg(msg: Odometry) -> OdometrySample:
    """Return a message's odometry; its covariances as they are, since a bad one says nothing against the pose."""
    position, rotated = msg.pose.pose.position, rotation(msg.pose.pose.orientation, "pose.pose.orientation")
    pose = SE2(
        number(position.x, "pose.pose.position.x"),
        number(position.y, "pose.pose.position.y"),
        yaw_from_quaternion(rotated),
    )
    velocity = _velocity(msg.twist.twist, "twist.twist")
    return OdometrySample(stamp(msg.header.stamp), pose, velocity, _covariance_of(msg.twist), _covariance_of(msg.pose))


def _put_covariance(msg: PoseWithCovariance | TwistWithCovariance, covariance: PlanarCovariance | None) -> None:
    for above, below, value in zip(_PLANAR, _MIRRORED, covariance or (), strict=False):
        msg.covariance[above] = msg.covariance[below] = value


def _covariance_of(msg: PoseWithCovariance | TwistWithCovariance) -> PlanarCovariance | None:
    """Return the planar part of a covariance, None where it is all zero, which is how a message says "unknown"."""
    entries = [float(msg.covariance[i]) for i in _PLANAR]
    return PlanarCovariance(*entries) if any(entries) else None


def velocity_to_msg(velocity: Velocity, stamp_ns: int) -> TwistStamped:
    """Return a command as a message, stamped with the cycle it answers."""
    msg = TwistStamped(header=header(stamp_ns, "base_link"))
    msg.twist.linear.x = velocity.forward
    msg.twist.angular.z = velocity.turn
    return msg


def velocity_from_msg(msg: TwistStamped) -> Velocity:
    """Return a message's command."""
    return _velocity(msg.twist, "twist")


def _velocity(twist: Twist, field: str) -> Velocity:
    return Velocity(number(twist.linear.x, f"{field}.linear.x"), number(twist.angular.z, f"{field}.angular.z"))


def sonar_to_msg(sweep: SonarSweep) -> SonarRingMsg:
    """Return a sweep as a message."""
    ring = sweep.ring
    return SonarRingMsg(
        header=header(sweep.stamp_ns, "base_link"),
        bearings=array("d", ring.bearings),
        mount_radius=ring.mount_radius_m,
        range_min=ring.range_min_m,
        range_max=ring.range_max_m,
        cone_half_angle=ring.cone_half_angle,
        sensor=array("B", (ping.sensor for ping in sweep.pings)),
        stamps=[stamp_to_msg(ping.stamp_ns) for ping in sweep.pings],
        ranges=array("d", (ping.range_m for ping in sweep.pings)),
    )


def sonar_from_msg(msg: SonarRingMsg) -> SonarSweep:
    """Return a message's sweep."""
    same_length(sensor=msg.sensor, stamps=msg.stamps, ranges=msg.ranges)
    range_min_m = number(msg.range_min, "range_min", 0.0, FARTHEST_M)
    ring = SonarRing(
        numbers(msg.bearings, "bearings"),
        number(msg.mount_radius, "mount_radius", 0.0, FARTHEST_M),
        range_min_m,
        number(msg.range_max, "range_max", range_min_m, FARTHEST_M),
        number(msg.cone_half_angle, "cone_half_angle", 0.0, math.pi),
    )
    pings = tuple(
        SonarPing(index(int(sensor), "sensor", len(ring.bearings)), stamp(fired, "stamps"), echo(range_m, "ranges"))
        for sensor, fired, range_m in zip(msg.sensor, msg.stamps, msg.ranges, strict=True)
    )
    return SonarSweep(stamp(msg.header.stamp), ring, pings)


def landmarks_to_msg(view: LandmarkView) -> LandmarkObservations:
    """Return a look of the landmark sensor as a message."""
    return LandmarkObservations(
        header=header(view.stamp_ns, "base_link"),
        range_max=view.range_max_m,
        ranges=array("d", (s.range_m for s in view.sightings)),
        bearings=array("d", (s.bearing for s in view.sightings)),
        range_stds=array("d", (s.range_std_m for s in view.sightings)),
        bearing_stds=array("d", (s.bearing_std for s in view.sightings)),
        sensor_x=view.field.sensor_x,
        sensor_y=view.field.sensor_y,
        view_from=view.field.bearing_from,
        view_to=view.field.bearing_to,
        range_min=view.field.range_min_m,
    )


def landmarks_from_msg(msg: LandmarkObservations) -> LandmarkView:
    """Return a message's look of the landmark sensor."""
    same_length(ranges=msg.ranges, bearings=msg.bearings, range_stds=msg.range_stds, bearing_stds=msg.bearing_stds)
    columns = zip(
        numbers(msg.ranges, "ranges", LEAST_RANGE_M, FARTHEST_M),
        numbers(msg.bearings, "bearings"),
        numbers(msg.range_stds, "range_stds", LEAST_STD, FARTHEST_M),
        numbers(msg.bearing_stds, "bearing_stds", LEAST_STD, math.tau),
        strict=True,
    )
    sightings = tuple(LandmarkSighting(*row) for row in columns)
    field = FieldOfView(
        number(msg.sensor_x, "sensor_x", -FARTHEST_M, FARTHEST_M),
        number(msg.sensor_y, "sensor_y", -FARTHEST_M, FARTHEST_M),
        number(msg.view_from, "view_from"),
        number(msg.view_to, "view_to"),
        number(msg.range_min, "range_min", 0.0, FARTHEST_M),
    )
    return LandmarkView(stamp(msg.header.stamp), number(msg.range_max, "range_max", 0.0, FARTHEST_M), sightings, field)


def event_to_msg(event: GvgEvent) -> GvgEventMsg:
    """Return a GVG event as a message."""
    msg = GvgEventMsg(
        header=header(event.stamp_ns, "odom"),
        sequence=event.sequence,
        kind=int(event.kind),
        has_node=event.node is not None,
        branch=event.branch,
        path_length=event.path_length_m,
    )
    if event.node is not None:
        msg.node = GvgNodeMsg(
            kind=int(event.node.kind),
            x=event.node.x_in_odom,
            y=event.node.y_in_odom,
            clearance=event.node.clearance_m,
            bearings=array("d", event.node.bearings_in_odom),
        )
    return msg


def event_from_msg(msg: GvgEventMsg) -> GvgEvent:
    """Return a message's GVG event; a departure names a branch of its node, an arrival has a node with branches."""
    kind = kind_of(EventKind, msg.kind, "kind")
    node = _node_from_msg(msg.node) if msg.has_node else None
    if kind in (EventKind.DEPARTURE, EventKind.ARRIVAL):
        if node is None or not node.degree:
            raise MessageError(f"{kind.name.lower()} without a node that branches leave")
        index(msg.branch, "branch", node.degree, low=0 if kind is EventKind.DEPARTURE else -1)
    path_length_m = number(msg.path_length, "path_length", 0.0)
    return GvgEvent(msg.sequence, stamp(msg.header.stamp), kind, node, msg.branch, path_length_m)


def _node_from_msg(msg: GvgNodeMsg) -> NodeView:
    return NodeView(
        kind_of(NodeKind, msg.kind, "node.kind"),
        number(msg.x, "node.x"),
        number(msg.y, "node.y"),
        number(msg.clearance, "node.clearance", 0.0),
        numbers(msg.bearings, "node.bearings"),
    )


def edge_map_to_msg(edge_map: EdgeMap, stamp_ns: int) -> EdgeMapMsg:
    """Return an edge-map as a message, stamped with its arrival."""
    return EdgeMapMsg(
        header=header(stamp_ns, edge_frame(edge_map.traversal)),
        traversal=edge_map.traversal,
        arrival=edge_map.arrival,
        terminal_x=edge_map.terminal_x,
        landmarks=array("d", edge_map.landmarks.ravel()),
        covariance=array("d", edge_map.covariance.ravel()),
        sightings=array("I", edge_map.sightings),
        departure_heading=edge_map.departure_heading,
        arrival_heading=edge_map.arrival_heading,
        robot_at_arrival=pose_to_msg(edge_map.robot_at_arrival),
        path_length=edge_map.path_length_m,
    )


def edge_map_from_msg(msg: EdgeMapMsg) -> EdgeMap:
    """Return a message's edge-map."""
    same_length(sightings=msg.sightings, x=msg.landmarks[0::2], y=msg.landmarks[1::2])
    return EdgeMap(
        traversal=msg.traversal,
        arrival=msg.arrival,
        terminal_x=number(msg.terminal_x, "terminal_x"),
        landmarks=np.array(numbers(msg.landmarks, "landmarks"), dtype=np.float64).reshape(-1, 2),
        covariance=covariance(msg.covariance, "covariance", 2 + len(msg.landmarks)),
        sightings=tuple(int(n) for n in msg.sightings),
        departure_heading=number(msg.departure_heading, "departure_heading"),
        arrival_heading=number(msg.arrival_heading, "arrival_heading"),
        robot_at_arrival=pose_from_msg(msg.robot_at_arrival, "robot_at_arrival"),
        path_length_m=number(msg.path_length, "path_length", 0.0),
    )


def link_to_msg(link: FrameLink, stamp_ns: int) -> FrameLinkMsg:
    """Return a link between frames as a message, stamped with its departure."""
    return FrameLinkMsg(
        header=header(stamp_ns, edge_frame(link.traversal)),
        traversal=link.traversal,
        departure=link.departure,
        departure_in_edge=pose_to_msg(link.departure_in_edge),
        covariance=link.covariance.ravel(),
    )


def link_from_msg(msg: FrameLinkMsg) -> FrameLink:
    """Return a message's link between frames."""
    departure_in_edge = pose_from_msg(msg.departure_in_edge, "departure_in_edge")
    return FrameLink(msg.traversal, msg.departure, departure_in_edge, covariance(msg.covariance, "covariance", 3))


def answer_from_msg(msg: NodeStatus) -> Answer:
    """Return a node's answer to a cycle."""
    return Answer(
        stamp(msg.header.stamp),
        msg.outputs,
        msg.finished,
        msg.state,
        number(msg.clearance, "clearance", 0.0),
        pose_from_msg(msg.base_in_odom, "base_in_odom"),
        msg.traversal if msg.tracked else -1,
        pose_from_msg(msg.base_in_edge, "base_in_edge") if msg.tracked else None,
        msg.next_event,
    )


def edge_frame(traversal: int) -> str:
    """Return the TF name of a traversal's edge frame."""
    return f"edge_{traversal}"
