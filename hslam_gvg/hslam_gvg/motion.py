"""Driving to a place and turning to a direction with a differential drive."""

import math

from hslam_gvg.control import drive
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity

SLOWING_RATE = 1.0
"""Speed allowed for each metre that is left (1/s)."""
LEAST_M_S = 0.04
"""A base's friction stops it below about this, short of the goal."""
LEAST_RAD_S = 0.15
"""The same for turning."""


def go_to(base_in_odom: SE2, x: float, y: float, speed: float, fastest_turn: float) -> Velocity:
    """Return the command towards a place (odom), backwards where that needs less turning: the ring looks all round."""
    dx, dy = x - base_in_odom.x, y - base_in_odom.y
    distance = math.hypot(dx, dy)
    if distance < 1e-9:
        return Velocity()
    error = wrap(math.atan2(dy, dx) - base_in_odom.theta)
    pace = min(speed, LEAST_M_S + SLOWING_RATE * distance) / distance
    return drive(base_in_odom, dx * pace, dy * pace, fastest_turn, backwards=abs(error) > 0.5 * math.pi)


def turn_to(base_in_odom: SE2, bearing: float, fastest: float) -> Velocity:
    """Return the turn on the spot towards a direction in odom (rad)."""
    error = wrap(bearing - base_in_odom.theta)
    rate = min(fastest, max(LEAST_RAD_S, 2.0 * abs(error)))
    return Velocity(0.0, math.copysign(rate, error))
