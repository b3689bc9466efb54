"""A planar scan as what every lidar driver publishes, sensor_msgs/LaserScan.

The message has single precision and does not say where the scanner sits: that comes from TF or from parameters.
"""

import math
from array import array

import numpy as np
from sensor_msgs.msg import LaserScan

from hslam_ros.checks import FARTHEST_M, number, stamp
from hslam_ros.conversions import header
from hslam_types.errors import MessageError
from hslam_types.se2 import SE2
from hslam_types.sensing import RangeScan

FRAME = "base_scan"
MOST_ROUND = 1.01 * math.tau
"""Beams once round, the first again as the last, and rounding."""


def scan_to_msg(scan: RangeScan, frame_id: str = FRAME) -> LaserScan:
    """Return a scan as a message, in the scanner's own frame, its numbers rounded as they will be on the way."""
    return LaserScan(
        header=header(scan.stamp_ns, frame_id),
        angle_min=_single(scan.first_bearing),
        angle_max=_single(scan.first_bearing + scan.bearing_step * (len(scan.ranges) - 1)),
        angle_increment=_single(scan.bearing_step),
        range_min=_single(scan.range_min_m),
        range_max=_single(scan.range_max_m),
        ranges=array("f", scan.ranges.astype(np.float32).tobytes()),
    )


def scan_from_msg(msg: LaserScan, sensor_in_base: SE2) -> RangeScan:
    """Return a message's scan, of whatever length and sense, by a scanner mounted at ``sensor_in_base``.

    A scan taken clockwise is turned about. Raises MessageError where angles or limits are no numbers, or the beams go
    more than once round; single readings that are none (REP-117) are for the map to leave out.
    """
    ranges = np.array(msg.ranges, dtype=np.float64)
    span = abs(number(msg.angle_increment, "angle_increment")) * max(len(ranges) - 1, 0)
    if len(ranges) > 1 and not 0.0 < span <= MOST_ROUND:
        raise MessageError(f"angle_increment = {msg.angle_increment:g} spreads {len(ranges)} beams over {span:g} rad")
    first, step = number(msg.angle_min, "angle_min"), msg.angle_increment
    if step < 0.0:
        first, step, ranges = first + step * (len(ranges) - 1), -step, ranges[::-1].copy()
    least = number(msg.range_min, "range_min", 0.0, FARTHEST_M)
    farthest = number(msg.range_max, "range_max", least, FARTHEST_M)
    return RangeScan(stamp(msg.header.stamp), sensor_in_base, first, step, least, farthest, ranges)


def _single(value: float) -> float:
    """Return a number in single precision: a message that is never sent would keep more."""
    return float(np.float32(value))
