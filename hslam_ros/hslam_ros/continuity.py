"""Whether odometry goes on where it was: a pose that jumps by metres says that the base, or its odometry, was moved."""

import math

from hslam_ros.stamps import NS_PER_S
from hslam_types.sensing import OdometrySample

_JUMP_M = 1.0
"""What no error of odometry makes within a cycle."""
_FASTEST = 3.0
"""Speed (m/s) that no base on a floor exceeds: where cycles are missing it may have come so far."""


class Continuity:
    """Compares each sample with the one before."""

    def __init__(self) -> None:
        """Begin without a sample."""
        self._last: OdometrySample | None = None

    def broken_by(self, odom: OdometrySample) -> str:
        """Return in words how a sample has jumped from the last one, empty where it has not or time has gone back."""
        last, self._last = self._last, odom
        if last is None or odom.stamp_ns < last.stamp_ns:
            return ""
        moved_m = math.dist(last.base_in_odom[:2], odom.base_in_odom[:2])
        if moved_m <= _JUMP_M + _FASTEST * (odom.stamp_ns - last.stamp_ns) / NS_PER_S:
            return ""
        return f"odometry jumped by {moved_m:.1f} m at {odom.stamp_ns / NS_PER_S:.2f} s"
