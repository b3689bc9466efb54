"""The pings of the last metres, and what they say of the space between two obstacle points."""

import math

import numpy as np
import numpy.typing as npt

from hslam_gvg.ranging.cone_ping import ConePing
from hslam_types.se2 import Array

CAPACITY = 1200
NOTHING_M = 9.0
"""Stands for the range of a ping that nothing answered."""
SAME_PLACE_M, SAME_RANGE_M, SAME_AXIS = 0.05, 0.06, math.cos(math.radians(3.0))
"""A ping from the same place, along the same axis, with the same answer says nothing new."""
CORE = 11.0 / 15.0
"""Share of its half cone in which a ping surely hears a wall that faces it (the lobe is weak towards its rim)."""
THROUGH = math.cos(math.radians(35.0))
"""A wall across a gap would have answered a ping that met it no flatter than so."""
THROUGH_M, PAST_M, ENDED_M = 2.2, 0.25, 0.12
"""Pings go through a gap this near, and past it by so much; or they end at it."""
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

        Only those count that a wall across the gap would have answered.
        """
        x, y, ux, uy, heard = self.recent(odometer_m)[:5]
        off_x, off_y = begin[:, 0, None] - x, begin[:, 1, None] - y
        gap = end - begin
        gap_x, gap_y = gap[:, 0, None], gap[:, 1, None]
        cross = ux * gap_y - uy * gap_x
        safe = np.where(np.abs(cross) < 1e-9, 1e-9, cross)
        way, share = (off_x * gap_y - off_y * gap_x) / safe, (off_x * uy - off_y * ux) / safe
        met = (way > 0.0) & (way < THROUGH_M) & (share > 0.1) & (share < 0.9)
        met &= np.abs(cross) > THROUGH * np.hypot(gap_x, gap_y)
        through = np.count_nonzero(met & (heard > way + PAST_M), axis=1)
        middle = (share > 0.25) & (share < 0.75)
        ended = np.count_nonzero(met & middle & (np.abs(heard - way) < ENDED_M), axis=1)
        return through, ended
