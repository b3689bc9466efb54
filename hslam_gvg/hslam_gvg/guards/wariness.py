"""Slowly past what may be there: an echo that no wall explains is minded until enough pings have gone past it."""

import math

import numpy as np

from hslam_types.se2 import SE2, Array
from hslam_types.sensing import Velocity

BESIDE_M = 0.06
"""The lane is so much wider than the body, to either side."""
CREEP_M_S, CREEP_FROM_M = 0.06, 0.35
"""The pace from this room on: the sonar ahead listens once in every six centimetres then."""
APPROACH_RATE = 0.8
"""Speed allowed for each metre of room beyond (1/s)."""


def wary(wanted: Velocity, base_in_odom: SE2, suspects: Array, body_m: float) -> Velocity:
    """Return the command at the pace that ``suspects`` (n x 2, m, odom) in the way of the body allow."""
    if wanted.forward == 0.0 or len(suspects) == 0:
        return wanted
    x, y, heading = base_in_odom
    way = heading if wanted.forward > 0.0 else heading + math.pi
    c, s = math.cos(way), math.sin(way)
    dx, dy = suspects[:, 0] - x, suspects[:, 1] - y
    in_way = (c * dx + s * dy > 0.0) & (np.abs(c * dy - s * dx) < body_m + BESIDE_M)
    room_m = float(np.hypot(dx[in_way], dy[in_way]).min(initial=math.inf)) - body_m
    allowed = max(CREEP_M_S, APPROACH_RATE * (room_m - CREEP_FROM_M))
    if abs(wanted.forward) <= allowed:
        return wanted
    return Velocity(math.copysign(allowed, wanted.forward), wanted.turn * allowed / abs(wanted.forward))
