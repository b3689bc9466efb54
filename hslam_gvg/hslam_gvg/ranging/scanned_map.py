"""The scanner's map as the driving wants it: which scans are mapped, and what the newest one shows near the body."""

import functools
import math

import numpy as np

from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.local_graph.gaps import OPEN, Gaps
from hslam_gvg.local_graph.open_space import OpenSpace
from hslam_gvg.ranging.rolling_grid import Mask
from hslam_gvg.ranging.scan_map import ScanMap
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_gvg.ranging.scan_match import Drift, matched, surface
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import OdometrySample, RangeScan, Velocity
from hslam_voronoi.rules import ReductionRules

STANDING_M, STANDING_RAD = 0.003, 0.002
"""What odometry may be wrong by without any way."""
NEAR_M = 0.8
"""Ends farther from the body do not matter to the next moves."""
OPEN_SHARE = 0.625
"""Open space begins at this share of the map's reach at most: a wall and the open space before it are seen at once."""


class ScannedMap:
    """A `hslam_gvg.ranging.local_map.LocalMap` by scans."""

    def __init__(self, config: FollowConfig, mapping: ScanMapConfig) -> None:
        """Begin with nothing known."""
        self._config, self._mapping = config, mapping
        self._map = ScanMap(mapping)
        self._heard_from: SE2 | None = None
        self._recent: Array = np.zeros((0, 2))

    def hear(self, heard: RangeScan | None, odom: OdometrySample, odometer_m: float, *, attentive: bool) -> SE2:
        """Take a scan, if there is one; while the robot hardly moves only an attentive one maps every scan."""
        base = odom.base_in_odom
        if heard is None:
            return base
        is_mapped = attentive or self._moved(base)
        if is_mapped:
            base = self._matched(heard, base)
        answered = np.isfinite(heard.ranges) & (heard.ranges < NEAR_M + self._config.body_m)
        directions = np.column_stack((np.cos(heard.bearings), np.sin(heard.bearings)))
        ends = heard.ranges[answered, None] * directions[answered]
        self._recent = (base @ heard.sensor_in_base).apply_all(ends)
        if is_mapped:
            self._heard_from = base
            self._map.hear(heard, base, odometer_m)
        return base

    def touch(self, x: float, y: float, odometer_m: float) -> None:
        """Note an obstacle that the body met and the scanner does not see."""
        self._map.touch(x, y, odometer_m)

    def obstacle_points(self) -> Array:
        """Return what is taken for obstacles, n x 2."""
        return self._map.obstacle_points()

    def is_free(self, x: Array, y: Array) -> Mask:
        """Return which points lie in cells known to be free."""
        return self._map.grid.is_free(x, y)

    def open_space(self) -> OpenSpace:
        """Return what is free and farther from every obstacle than the truth's rules say, as far as the map reaches."""
        grid = self._map.grid
        far = grid.free_and_far(min(ReductionRules().open_m, OPEN_SHARE * self._mapping.reach_m))
        return OpenSpace(grid.outline(far), functools.partial(grid.contains, far))

    def gaps(self, begin: Array, end: Array) -> Gaps:
        """Return that all gaps are open: a scanner draws walls whole."""
        del end
        return np.full(len(begin), OPEN, np.int8)

    def recent(self) -> Array:
        """Return the ends of the newest scan near the body, n x 2."""
        return self._recent

    def limited(self, wanted: Velocity, base_in_odom: SE2, obstacles: Array) -> tuple[Velocity, bool]:
        """Return the command as it is: what a scanner does not see it has no doubts about."""
        del base_in_odom, obstacles
        return wanted, False

    def _matched(self, heard: RangeScan, base: SE2) -> SE2:
        """Return the pose at which a scan fits the map, as far from where odometry says as that may be wrong."""
        last, config = self._heard_from, self._mapping
        if last is None or config.match_gate_m == 0.0:
            return base
        way = math.hypot(base.x - last.x, base.y - last.y)
        drift = Drift(
            STANDING_M + config.slip_per_metre * way,
            STANDING_RAD + config.bend_per_metre * way + config.turn_slip * abs(wrap(base.theta - last.theta)),
        )
        return matched(surface(heard, config.reach_m), base, self._map.obstacle_points(), drift, config.match_gate_m)

    def _moved(self, base: SE2) -> bool:
        last, config = self._heard_from, self._config
        if last is None:
            return True
        way = math.hypot(base.x - last.x, base.y - last.y)
        return way > config.hear_every_m or abs(wrap(base.theta - last.theta)) > config.hear_every_rad
