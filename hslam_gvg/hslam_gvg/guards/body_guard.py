"""The body along the commanded arc stays off everything that is known."""

import math

import numpy as np

from hslam_types.se2 import SE2, Array
from hslam_types.sensing import Velocity

SHARES = (1.0, 0.6, 0.3)
"""A command is tried whole, then slower."""
FIRST_S, LAST_S, LAST_SLOW_S, FAST_M_S = 0.24, 0.5, 0.7, 0.2
"""The body's place is foreseen at two times; slow commands are looked at a little farther ahead."""
NEARER_M = 0.003
"""A body that is too near already may move as long as it comes no nearer than by this."""


def limited(wanted: Velocity, base_in_odom: SE2, obstacles: Array, room_m: float) -> tuple[Velocity, bool]:
    """Return the command that keeps ``room_m`` to ``obstacles`` (n x 2, m, odom), and whether it had to be stopped.

    Turning on the spot is always free: the body is round.
    """
    if wanted.forward == 0.0 or len(obstacles) == 0:
        return wanted, False
    x, y, heading = base_in_odom
    now = float(np.hypot(obstacles[:, 0] - x, obstacles[:, 1] - y).min())
    for share in SHARES:
        forward, turn = wanted.forward * share, wanted.turn * share
        last_s = LAST_S if abs(forward) > FAST_M_S else LAST_SLOW_S
        for ahead_s in (FIRST_S, last_s):
            way, direction = forward * ahead_s, heading + 0.5 * turn * ahead_s
            px, py = x + way * math.cos(direction), y + way * math.sin(direction)
            least = float(np.hypot(obstacles[:, 0] - px, obstacles[:, 1] - py).min())
            if least < min(room_m, now - NEARER_M):
                break
        else:
            return Velocity(forward, turn), False
    return Velocity(0.0, wanted.turn), True
