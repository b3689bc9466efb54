"""Ways that have lately proved blocked."""

import math
from typing import NamedTuple

from hslam_gvg.config import GvgConfig
from hslam_types.se2 import SE2, wrap

HERE_M = 0.8
"""A way is remembered for places this near to where it was tried."""
SAME_WAY = math.radians(60.0)
"""Ways less than this apart are one: two branches of a node are seldom nearer."""


class _Obstruction(NamedTuple):
    x: float
    y: float
    way: float
    until_m: float


class Obstructions:
    """Remembers for some travel which way (rad, odom) was blocked where."""

    def __init__(self, config: GvgConfig) -> None:
        """Begin with none."""
        self._config = config
        self._known: list[_Obstruction] = []

    def add(self, base_in_odom: SE2, way: float, travel_m: float) -> None:
        """Note that a way is blocked from here; ``travel_m`` is the odometer."""
        until_m = travel_m + self._config.suppress_travel_m
        self._known.append(_Obstruction(base_in_odom.x, base_in_odom.y, way, until_m))

    def free(self, ways: tuple[float, ...], base_in_odom: SE2, travel_m: float) -> list[float]:
        """Return the ways that have not just proved blocked from about here."""
        self._known = [o for o in self._known if travel_m < o.until_m]
        near = [o.way for o in self._known if math.hypot(o.x - base_in_odom.x, o.y - base_in_odom.y) < HERE_M]
        return [way for way in ways if all(abs(wrap(way - blocked)) > SAME_WAY for blocked in near)]
