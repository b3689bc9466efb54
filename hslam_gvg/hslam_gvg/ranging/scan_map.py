"""The local map that a planar scanner draws: the newest look wins, whatever it says.

What one scan shows free is the polygon of its ends; its walls are the ends themselves, joined where two neighbouring
beams meet one surface.  Nothing lasts longer than some metres of travel, because odometry drifts.
"""

import math

import cv2
import numpy as np

from hslam_gvg.ranging.rolling_grid import RollingGrid
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import RangeScan

SHRINK_M = 0.03
"""The free polygon ends this much before its walls: about three deviations of a range."""
LEAST_GRAZING = math.radians(10.0)
"""Neighbouring ends are taken for one surface if it is met at no flatter an angle."""
SUBCELL = 4
"""Binary digits of a cell's fraction in which OpenCV takes a polygon's corners."""


class ScanMap:
    """Obstacle points and known free space round the robot, in odom (m)."""

    def __init__(self, config: ScanMapConfig) -> None:
        """Begin with nothing known."""
        self._config = config
        self._grid = RollingGrid(config.cell_m, config.reach_m + config.margin_m)
        self._touched: list[tuple[float, float, float]] = []
        """Where the body was held: x, y and the odometer reading."""

    @property
    def grid(self) -> RollingGrid:
        """The cells: known free, occupied, unknown."""
        return self._grid

    def obstacle_points(self) -> Array:
        """Return what is taken for obstacles, n x 2."""
        return self._grid.obstacle_points()

    def touch(self, x: float, y: float, odometer_m: float) -> None:
        """Note an obstacle that the body met and the scanner does not see."""
        self._touched.append((x, y, odometer_m))
        self._grid.occupy(np.array([[x, y]]), odometer_m)

    def hear(self, scan: RangeScan, base_in_odom: SE2, odometer_m: float) -> None:
        """Take a scan, made from a pose of base_link."""
        self._grid.follow(base_in_odom.x, base_in_odom.y)
        self._grid.forget_before(odometer_m - self._config.memory_m)
        sensor = base_in_odom @ scan.sensor_in_base
        ends = _Ends(scan, sensor, self._config)
        self._grid.free(self._inside(ends.polygon()), odometer_m)
        self._grid.occupy(ends.walls(self._config.cell_m), odometer_m)
        self._touched = [t for t in self._touched if odometer_m - t[2] < self._config.touch_memory_m]
        if self._touched:
            self._grid.occupy(np.array(self._touched)[:, :2], odometer_m)

    def _inside(self, polygon: Array) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
        """Return which cells lie within a polygon (n x 2, m)."""
        grid = self._grid
        corners = polygon / grid.cell_m - np.array([grid.column_0 + 0.5, grid.row_0 + 0.5])
        fixed = np.round(corners * 2**SUBCELL).astype(np.int32)
        mask = np.zeros((grid.size, grid.size), np.uint8)
        cv2.fillPoly(mask, [fixed], 1, lineType=cv2.LINE_8, shift=SUBCELL)
        return mask.astype(bool)


class _Ends:
    """Where the beams of one scan end."""

    def __init__(self, scan: RangeScan, sensor: SE2, config: ScanMapConfig) -> None:
        self._sensor, self._step, self._gap_m = sensor, scan.bearing_step, config.bridged_m
        ranges = np.where(np.isneginf(scan.ranges), scan.range_min_m, scan.ranges)
        reach = min(config.reach_m, scan.range_max_m)
        # What answers from beyond the map's reach is free as far as the map goes.
        self._hit = (ranges >= scan.range_min_m) & (ranges <= reach)
        nothing = np.isposinf(ranges) & ~_swallowed(ranges, scan.bearing_step, config.swallowed_m)
        self._range = np.where(
            self._hit, ranges, np.where(nothing | (ranges > reach) & np.isfinite(ranges), reach, 0.0)
        )
        angle = scan.bearings + sensor.theta
        self._c, self._s = np.cos(angle), np.sin(angle)
        self._full = len(ranges) * scan.bearing_step > math.tau - 0.5 * scan.bearing_step

    def polygon(self) -> Array:
        free = np.where(self._hit, np.maximum(self._range - SHRINK_M, 0.0), self._range)
        corners = np.column_stack((self._sensor.x + free * self._c, self._sensor.y + free * self._s))
        return corners if self._full else np.vstack((corners, [self._sensor.x, self._sensor.y]))

    def walls(self, spacing_m: float) -> Array:
        """Return the ends, and points between those neighbours that meet one surface."""
        x, y = self._sensor.x + self._range * self._c, self._sensor.y + self._range * self._s
        ends = np.column_stack((x, y))
        following = np.roll(ends, -1, axis=0)
        gap = np.hypot(*(following - ends).T)
        nearer = np.minimum(self._range, np.roll(self._range, -1))
        limit = nearer * math.sin(self._step) / math.sin(LEAST_GRAZING) + spacing_m
        one = self._hit & np.roll(self._hit, -1) & (gap < np.minimum(limit, self._gap_m)) & (gap > spacing_m)
        if not self._full:
            one[-1] = False
        which = np.flatnonzero(one)
        count = np.ceil(gap[which] / spacing_m).astype(np.int64)
        each = np.repeat(which, count)
        place = np.arange(len(each)) - np.repeat(np.cumsum(count) - count, count)
        share = (place + 0.5) / np.repeat(count, count)
        between = ends[each] + share[:, None] * (following[each] - ends[each])
        return np.concatenate((ends[self._hit], between))


def _swallowed(ranges: Array, step: float, width_m: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return which silent beams say nothing: so few between two answers that a dark surface may have swallowed them."""
    silent = np.isposinf(ranges)
    if not silent.any() or silent.all():
        return np.zeros(len(ranges), bool)
    # From the first answer on, so that no run of silent beams goes over the end.
    turn = int(np.argmin(silent))
    rolled = np.roll(silent, -turn)
    edges = np.diff(np.concatenate(([0], rolled.astype(np.int8), [0])))
    begin, end = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    turned = np.roll(ranges, -turn)
    bounds = np.minimum(turned[begin - 1], turned[end % len(ranges)])
    narrow = (end - begin + 1) * step * bounds < width_m
    doubtful = np.zeros(len(ranges), bool)
    for first, last in zip(begin[narrow], end[narrow], strict=True):
        doubtful[first:last] = True
    return np.roll(doubtful, turn)
