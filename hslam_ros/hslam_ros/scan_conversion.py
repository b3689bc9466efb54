"""A planar scan as what every lidar driver publishes, sensor_msgs/LaserScan.

The message has single precision and does not say where the scanner sits: that comes from TF or from parameters.
"""

from array import array

import numpy as np
from sensor_msgs.msg import LaserScan

from hslam_ros.conversions import header
from hslam_ros.stamps import stamp_from_msg
from hslam_types.se2 import SE2
from hslam_types.sensing import RangeScan

FRAME = "base_scan"


def scan_to_msg(scan: RangeScan, frame_id: str = FRAME) -> LaserScan:
    """Return a scan as a message, in the scanner's own frame."""
    return LaserScan(
        header=header(scan.stamp_ns, frame_id),
        angle_min=scan.first_bearing,
        angle_max=scan.first_bearing + scan.bearing_step * (len(scan.ranges) - 1),
        angle_increment=scan.bearing_step,
        range_min=scan.range_min_m,
        range_max=scan.range_max_m,
        ranges=array("f", scan.ranges.astype(np.float32).tobytes()),
    )


def scan_from_msg(msg: LaserScan, sensor_in_base: SE2) -> RangeScan:
    """Return a message's scan, of whatever length, by a scanner mounted at ``sensor_in_base``."""
    ranges = np.array(msg.ranges, dtype=np.float64)
    stamp_ns = stamp_from_msg(msg.header.stamp)
    return RangeScan(stamp_ns, sensor_in_base, msg.angle_min, msg.angle_increment, msg.range_min, msg.range_max, ranges)
