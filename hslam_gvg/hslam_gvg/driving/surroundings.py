"""What the robot knows round itself: the map, the graph made of it at the last look, and how far it has travelled."""

import math

import numpy as np

from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.local_graph.local_graph import LocalGraph, local_graph
from hslam_gvg.ranging.odometer import Odometer
from hslam_gvg.ranging.scan_map import ScanMap
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import RangeScan

NEAR_M = 0.8
"""Obstacles farther off do not matter to the next moves."""
FEW_POINTS = 4
"""Fewer obstacle points make no graph."""


class Surroundings:
    """Owns the local map; everything in odom (m, rad)."""

    def __init__(self, config: FollowConfig, mapping: ScanMapConfig, graph: LocalGraphConfig) -> None:
        """Begin knowing nothing."""
        self._config, self._graph_config = config, graph
        self.map = ScanMap(mapping)
        self._odometer = Odometer(config.metres_per_radian)
        self.pose = SE2()
        self.graph: LocalGraph | None = None
        """The reduced GVG as of the last look."""
        self.points: Array = np.zeros((0, 2))
        """The obstacle points as of the last look, n x 2."""
        self._looked_m = -math.inf
        self._heard_from: SE2 | None = None
        self._latest: Array = np.zeros((0, 2))

    @property
    def travel_m(self) -> float:
        """The odometer's reading."""
        return self._odometer.travel_m

    @property
    def step_m(self) -> float:
        """Way driven in the last step."""
        return self._odometer.step_m

    def move(self, base_in_odom: SE2) -> None:
        """Take the robot's next pose."""
        self.pose = base_in_odom
        self._odometer.move(base_in_odom)

    def hear(self, scan: RangeScan, *, attentive: bool) -> None:
        """Take a scan; while the robot hardly moves only an attentive one puts every scan into the map."""
        answered = np.isfinite(scan.ranges) & (scan.ranges < NEAR_M + self._config.body_m)
        ends = scan.ranges[answered, None] * np.column_stack((np.cos(scan.bearings), np.sin(scan.bearings)))[answered]
        self._latest = (self.pose @ scan.sensor_in_base).apply_all(ends)
        if attentive or self._moved():
            self._heard_from = self.pose
            self.map.hear(scan, self.pose, self.travel_m)

    def touch(self, bearing: float) -> None:
        """Note that the body was held by something in a direction (rad)."""
        reach = self._config.body_m + 0.02
        for aside in (-0.6, 0.0, 0.6):
            x, y = math.cos(bearing + aside), math.sin(bearing + aside)
            self.map.touch(self.pose.x + reach * x, self.pose.y + reach * y, self.travel_m)

    def look(self) -> None:
        """Make the local graph anew from what the map has now."""
        self._looked_m = self.travel_m
        self.points = self.map.obstacle_points()
        if len(self.points) < FEW_POINTS:
            self.graph = None
            return
        x, y, _ = self.pose
        self.graph = local_graph(self.points, self.map.grid.is_free, x, y, self._graph_config)

    def look_is_due(self) -> bool:
        """Whether the robot has travelled far enough since the last look."""
        return self.travelled_since_look_m >= self._config.look_every_m

    @property
    def travelled_since_look_m(self) -> float:
        """How far the robot has travelled since the last look."""
        return self.travel_m - self._looked_m

    def clearance(self, x: float, y: float) -> float:
        """Return the distance (m) from a place to the nearest obstacle; +inf where none is known."""
        points = self.points
        return float(np.hypot(points[:, 0] - x, points[:, 1] - y).min(initial=math.inf))

    def near(self) -> Array:
        """Return the obstacles that matter to the next moves: of the map, and of the newest scan."""
        x, y, _ = self.pose
        points = np.concatenate((self.points, self._latest))
        return points[(np.abs(points[:, 0] - x) < NEAR_M) & (np.abs(points[:, 1] - y) < NEAR_M)]

    def line_is_clear(self, x: float, y: float) -> bool:
        """Whether the body passes straight to a place, or at least comes no nearer to anything than it is."""
        points = self.near()
        if len(points) == 0:
            return True
        dx, dy = x - self.pose.x, y - self.pose.y
        off_x, off_y = points[:, 0] - self.pose.x, points[:, 1] - self.pose.y
        squared = dx * dx + dy * dy
        if squared < 1e-6:
            return True
        share = np.clip((off_x * dx + off_y * dy) / squared, 0.0, 1.0)
        least = float(np.hypot(off_x - share * dx, off_y - share * dy).min())
        now = float(np.hypot(off_x, off_y).min())
        return least >= self._config.body_m + self._config.margin_m + 0.01 or least >= now - 0.005

    def _moved(self) -> bool:
        last, config = self._heard_from, self._config
        if last is None:
            return True
        way = math.hypot(self.pose.x - last.x, self.pose.y - last.y)
        return way > config.hear_every_m or abs(wrap(self.pose.theta - last.theta)) > config.hear_every_rad
