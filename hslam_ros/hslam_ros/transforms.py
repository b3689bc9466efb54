"""Planar transforms for `/tf`; broadcasting them needs no more than the message."""

from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from hslam_ros.conversions import header, yaw_to_quaternion
from hslam_types.se2 import SE2


def transform_to_msg(stamp_ns: int, parent: str, child: str, child_in_parent: SE2) -> TFMessage:
    """Return the transform that puts frame ``child`` into frame ``parent``."""
    msg = TransformStamped(header=header(stamp_ns, parent), child_frame_id=child)
    msg.transform.translation.x = child_in_parent.x
    msg.transform.translation.y = child_in_parent.y
    msg.transform.rotation = yaw_to_quaternion(child_in_parent.theta)
    return TFMessage(transforms=[msg])
