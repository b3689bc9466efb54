"""What `ekf_node` shows beyond its maps: the pose in the edge, TF edge -> odom, the live map as markers."""

import math
from itertools import pairwise

import numpy as np
from geometry_msgs.msg import Point, PoseWithCovarianceStamped
from hslam_msgs.msg import NodeStatus
from std_msgs.msg import ColorRGBA, Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from hslam_ekf.landmark_filter import LandmarkFilter
from hslam_ekf.motion_model import ROBOT
from hslam_ekf.server import EkfOutput
from hslam_ros import conversions
from hslam_ros.conversions import edge_frame, header, yaw_to_quaternion
from hslam_ros.transforms import transform_to_msg
from hslam_types.se2 import SE2, Array

_PLANAR = (0, 1, 5)
"""Rows of x, y and yaw in a pose's 6 x 6 covariance (REP-103)."""
_AZIMUTHS = np.linspace(0.0, math.tau, 9)
_CIRCLE = np.column_stack((np.cos(_AZIMUTHS), np.sin(_AZIMUTHS)))
"""An octagon, closed: a picture of many ellipses is sent again and again."""
_PINK = ColorRGBA(r=1.0, g=0.4, b=0.7, a=1.0)
_GREY = ColorRGBA(r=0.6, g=0.6, b=0.6, a=1.0)


def pose_to_msg(stamp_ns: int, traversal: int, base_in_edge: SE2, covariance: Array) -> PoseWithCovarianceStamped:
    """Return the pose of base_link in a traversal's frame with its covariance (3 x 3 over x, y, theta)."""
    msg = PoseWithCovarianceStamped(header=header(stamp_ns, edge_frame(traversal)))
    msg.pose.pose.position.x = base_in_edge.x
    msg.pose.pose.position.y = base_in_edge.y
    msg.pose.pose.orientation = yaw_to_quaternion(base_in_edge.theta)
    full = np.zeros((6, 6))
    full[np.ix_(_PLANAR, _PLANAR)] = covariance
    msg.pose.covariance = full.ravel()
    return msg


def odom_in_edge_to_msg(stamp_ns: int, traversal: int, base_in_edge: SE2, base_in_odom: SE2) -> TFMessage:
    """Return the transform edge -> odom that puts base_link where the filter has it."""
    return transform_to_msg(stamp_ns, edge_frame(traversal), "odom", base_in_edge @ base_in_odom.inverse())


def place_to_status(base_in_odom: SE2, out: EkfOutput) -> NodeStatus:
    """Return a status that says where the robot is after a step, and nothing else yet."""
    status = NodeStatus(base_in_odom=conversions.pose_to_msg(base_in_odom))
    if out.base_in_edge is not None:
        status.tracked, status.traversal = True, out.traversal
        status.base_in_edge = conversions.pose_to_msg(out.base_in_edge)
    return status


def map_to_msg(stamp_ns: int, traversal: int, ekf: LandmarkFilter, ellipse_scale: float) -> MarkerArray:
    """Return the live map as markers: landmarks, and their one-sigma ellipses enlarged by ``ellipse_scale``."""
    about = header(stamp_ns, edge_frame(traversal))
    landmarks = _marker(about, "landmarks", Marker.SPHERE_LIST, 0.15, _PINK)
    landmarks.points = [Point(x=x, y=y) for x, y in ekf.landmarks.tolist()]
    ellipses = _marker(about, "ellipses", Marker.LINE_LIST, 0.02, _GREY)
    own = ROBOT + 2 * np.arange(len(ekf.landmarks))[:, None, None] + np.arange(2)
    # A floor on the diagonal keeps the root of a barely positive block real.
    roots = np.linalg.cholesky(ekf.covariance[own.transpose(0, 2, 1), own] + 1e-12 * np.eye(2))
    rings = ekf.landmarks[:, None] + ellipse_scale * _CIRCLE @ roots.transpose(0, 2, 1)
    for ring in rings.tolist():
        ellipses.points += [point for side in pairwise(Point(x=x, y=y) for x, y in ring) for point in side]
    return MarkerArray(markers=[landmarks, ellipses])


def _marker(about: Header, namespace: str, kind: int, size_m: float, colour: ColorRGBA) -> Marker:
    """Return an empty marker list in a frame."""
    marker = Marker(header=about, ns=namespace, type=kind, action=Marker.ADD, color=colour)
    marker.scale.x = marker.scale.y = marker.scale.z = size_m
    marker.pose.orientation.w = 1.0
    return marker
