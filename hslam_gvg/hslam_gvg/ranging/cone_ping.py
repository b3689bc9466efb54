"""One ping of one sensor that hears a cone, where it was fired: what the sonar map is made of.

Whatever listens to a cone (a sonar of a ring, a `sensor_msgs/Range`) says this, with its own mounting and its own cone.
"""

import math
from typing import NamedTuple

from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import OdometrySample, SonarSweep


class ConePing(NamedTuple):
    """A place and a direction in odom, and how far away the first echo was."""

    x: float
    """The transducer's face (m)."""
    y: float
    axis: float
    """Direction of the cone's axis (rad)."""
    range_m: float
    """Distance of the first echo from the face; +inf where nothing answered."""
    half_cone: float
    """Half the main lobe (rad)."""


def cone_pings(sweep: SonarSweep, bases: tuple[SE2, ...]) -> tuple[ConePing, ...]:
    """Return the pings of a sweep, by the pose of base_link in odom at each."""
    ring, pings = sweep.ring, []
    for ping, base in zip(sweep.pings, bases, strict=True):
        axis = base.theta + ring.bearings[ping.sensor]
        x = base.x + ring.mount_radius_m * math.cos(axis)
        y = base.y + ring.mount_radius_m * math.sin(axis)
        heard = ping.range_m if ring.range_min_m <= ping.range_m < ring.range_max_m else math.inf
        pings.append(ConePing(x, y, axis, heard, ring.cone_half_angle))
    return tuple(pings)


class PingPlaces:
    """Where the base was when each ping was fired: between the last two odometry samples."""

    def __init__(self) -> None:
        """Begin before the first sample."""
        self._last: OdometrySample | None = None

    def of(self, sweep: SonarSweep, odom: OdometrySample) -> tuple[SE2, ...]:
        """Return base_link in odom at each ping of the sweep that came with a sample; to be called once a cycle."""
        bases = tuple(self._base_at(ping.stamp_ns, odom) for ping in sweep.pings)
        self._last = odom
        return bases

    def _base_at(self, stamp_ns: int, odom: OdometrySample) -> SE2:
        last = self._last
        if last is None or stamp_ns >= odom.stamp_ns or last.stamp_ns >= odom.stamp_ns:
            return odom.base_in_odom
        share = max(0.0, (stamp_ns - last.stamp_ns) / (odom.stamp_ns - last.stamp_ns))
        a, b = last.base_in_odom, odom.base_in_odom
        return SE2(
            a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), wrap(a.theta + share * wrap(b.theta - a.theta))
        )
