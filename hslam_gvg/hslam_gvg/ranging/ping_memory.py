"""The pings of the last metres, and what they say of the space between two obstacle points."""

import math

import numpy as np
import numpy.typing as npt

from hslam_gvg.ranging.cone_ping import ConePing
from hslam_types.se2 import Array

CAPACITY = 1200
"""Pings; where a slow robot sends more over `memory_m`, the oldest go."""
NOTHING_M = 9.0
"""Stands for the range of a ping that nothing answered."""
SAME_PLACE_M, SAME_RANGE_M, SAME_AXIS = 0.05, 0.06, math.cos(math.radians(3.0))
"""A ping from the same place, along the same axis, with the same answer says nothing new."""
CORE = 11.0 / 15.0
"""Share of its half cone in which a ping surely hears a wall that faces it (the lobe is weak towards its rim)."""
FACED = math.tan(math.radians(22.0))
"""A wall surely answers a ping that meets it no flatter than so (specular above 25 to 30 degrees)."""
THROUGH_M, PAST_M, ENDED_M = 2.2, 0.25, 0.12
"""Pings go through a gap this near, and past it by so much at least; or they end at it."""
POCKET = 0.5
"""A corner that was not heard lies this far behind the gap in its place, in widths of it: such a gap is no way."""
JAMB = 0.1
"""Share of a gap at either end where its jambs answer."""
Counts = npt.NDArray[np.intp]


class PingMemory:
    """A ring buffer of pings; places in odom (m)."""

    def __init__(self, memory_m: float) -> None:
        """Begin empty; pings older than ``memory_m`` of travel do not count."""
        self._memory_m = memory_m
        self._columns = np.zeros((8, CAPACITY))
        """x, y, cosine and sine of the axis, range, odometer reading, cosines of rim and core of the cone."""
        self._columns[5] = -math.inf
        self._next = 0

    def is_new(self, ping: ConePing, odometer_m: float) -> bool:
        """Keep a ping; whether it says anything that none in memory has said: standing still is no evidence."""
        x, y, c, s, ranges, born, _, _ = self._columns
        heard, ux, uy = min(ping.range_m, NOTHING_M), math.cos(ping.axis), math.sin(ping.axis)
        again = np.abs(x - ping.x) + np.abs(y - ping.y) < SAME_PLACE_M
        again &= (np.abs(ranges - heard) < SAME_RANGE_M) & (c * ux + s * uy > SAME_AXIS)
        again &= born > odometer_m - self._memory_m
        if again.any():
            born[again] = odometer_m
            return False
        rim, core = math.cos(ping.half_cone), math.cos(CORE * ping.half_cone)
        self._columns[:, self._next] = ping.x, ping.y, ux, uy, heard, odometer_m, rim, core
        self._next = (self._next + 1) % CAPACITY
        return True

    def newest(self) -> Array:
        """Return the ping kept last: 8."""
        newest: Array = self._columns[:, self._next - 1]
        return newest

    def recent(self, odometer_m: float) -> Array:
        """Return the pings that count: 8 x n."""
        return self._columns[:, self._columns[5] > odometer_m - self._memory_m]

    def met(self, begin: Array, end: Array, odometer_m: float) -> tuple[Counts, Counts]:
        """Return how many pings went through each gap (``begin`` to ``end``, n x 2 each), and how many ended at it.

        Only those count that a wall across the gap would have answered: some of it lies in the core of the cone, and is
        met squarely enough.
        """
        x, y, ux, uy, heard, _, _, core = self.recent(odometer_m)
        gap = end - begin
        width = np.hypot(gap[:, 0], gap[:, 1])[:, None] + 1e-9
        tx, ty = gap[:, 0, None] / width, gap[:, 1, None] / width
        off_x, off_y = x - begin[:, 0, None], y - begin[:, 1, None]
        foot, aside = off_x * tx + off_y * ty, off_y * tx - off_x * ty
        # How the axis leads along the gap and across it, away from the sonar.
        along, across = ux * tx + uy * ty, np.where(aside > 0.0, ux * ty - uy * tx, uy * tx - ux * ty)
        away = np.abs(aside)
        axis, half = np.arctan2(along, across), np.arccos(core)
        flat = 0.5 * math.pi - 0.01
        low = np.maximum(foot + away * np.tan(np.clip(axis - half, -flat, flat)), foot - away * FACED)
        high = np.minimum(foot + away * np.tan(np.clip(axis + half, -flat, flat)), foot + away * FACED)
        low, high = np.maximum(low, JAMB * width), np.minimum(high, (1.0 - JAMB) * width)
        distance = np.hypot(away, np.clip(foot, low, high) - foot)
        met = (high > low) & (across > 0.0) & (distance < THROUGH_M)
        pocket_m = ENDED_M + POCKET * width
        through = np.count_nonzero(met & (heard > distance + np.maximum(PAST_M, pocket_m)), axis=1)
        ended = np.count_nonzero(met & (heard > distance - ENDED_M) & (heard < distance + pocket_m), axis=1)
        return through, ended
