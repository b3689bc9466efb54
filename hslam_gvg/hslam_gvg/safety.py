"""The reflex: raw pings bound the speed, last before the command leaves.

The local map forgets, averages and waits for confirmation; what the sonars hear right now ahead of the body
does not.  The nearer the first echo, the slower.  Within `stop_m` it may still be noise: crawl; confirmed by a second
within `second_echo_m`, or at half the room: stop.
"""

import math
from collections import deque
from typing import NamedTuple

from hslam_gvg.config import GvgConfig
from hslam_types.se2 import SE2
from hslam_types.sensing import SonarSweep, Velocity

HEARD_NS = 1_300_000_000
"""Echoes are minded for a little longer than a full sweep of the ring takes,"""
CREPT_NS, CREPT_M = 2_600_000_000, 0.3
"""and for so long where the robot has hardly moved since: an edge that has answered once may keep silent then."""
SIDE_ROOM_M = 0.06
"""What passes the body this close is in its way: a sonar does not tell where in its cone the echo lies."""
APPROACH_RATE = 0.8
"""Speed allowed for each metre of room (1/s): it must halve faster than the ring goes round."""
CRAWL_M_S = 0.08
"""Allowed whatever was heard once: at this speed the ring goes round within about a decimetre."""


class _Echo(NamedTuple):
    stamp_ns: int
    x: float
    y: float
    travel_m: float


class Reflex:
    """Remembers the last echoes and limits commands by them."""

    def __init__(self, config: GvgConfig) -> None:
        """Start without echoes."""
        self._config = config
        self._echoes: deque[_Echo] = deque()
        self._travel_m = 0.0
        self._at: SE2 | None = None
        self.blocked = False
        """Whether the last command was stopped."""

    def hear(self, sweep: SonarSweep, poses: tuple[SE2, ...]) -> None:
        """Take a sweep; ``poses`` holds base_link in odom at each ping."""
        ring = sweep.ring
        while self._echoes and self._is_old(self._echoes[0], sweep.stamp_ns):
            self._echoes.popleft()
        for ping, pose in zip(sweep.pings, poses, strict=True):
            if self._at is not None:
                self._travel_m += math.hypot(pose.x - self._at.x, pose.y - self._at.y)
            self._at = pose
            if ping.range_m < 1.5:
                axis, reach = ring.bearings[ping.sensor], ring.mount_radius_m + ping.range_m
                x, y = pose.apply(reach * math.cos(axis), reach * math.sin(axis))
                self._echoes.append(_Echo(ping.stamp_ns, x, y, self._travel_m))

    def _is_old(self, echo: _Echo, stamp_ns: int) -> bool:
        age_ns = stamp_ns - echo.stamp_ns
        return age_ns > HEARD_NS and (age_ns > CREPT_NS or self._travel_m - echo.travel_m > CREPT_M)

    def room(self, base_in_odom: SE2, backwards: bool) -> tuple[float, float]:
        """Return the nearest and the second nearest room (m) from the body to echoes in its way; inf for none."""
        sign = -1.0 if backwards else 1.0
        c, s = sign * math.cos(base_in_odom.theta), sign * math.sin(base_in_odom.theta)
        rooms, body_m = [], self._config.body_m
        for echo in self._echoes:
            dx, dy = echo.x - base_in_odom.x, echo.y - base_in_odom.y
            forward, left = c * dx + s * dy, c * dy - s * dx
            if forward > 0.0 and abs(left) < body_m + SIDE_ROOM_M:
                rooms.append(math.hypot(dx, dy) - body_m)
        rooms.sort()
        return (*rooms, math.inf, math.inf)[0], (*rooms, math.inf, math.inf)[1]

    def limit(self, wanted: Velocity, base_in_odom: SE2) -> Velocity:
        """Return the command that the echoes allow; turning on the spot always is."""
        self.blocked = False
        if wanted.forward == 0.0:
            return wanted
        config = self._config
        first, second = self.room(base_in_odom, wanted.forward < 0.0)
        allowed = max(CRAWL_M_S, APPROACH_RATE * (first - config.stop_m))
        if first < config.stop_m and (second < config.second_echo_m or first < 0.5 * config.stop_m):
            allowed = 0.0
            self.blocked = True
        return Velocity(max(-allowed, min(allowed, wanted.forward)), wanted.turn)
