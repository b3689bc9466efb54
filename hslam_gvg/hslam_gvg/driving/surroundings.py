"""What the robot knows round itself: the map, the graph made of it at the last look, and how far it has travelled."""

import dataclasses
import math
from typing import Any

import numpy as np

from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.guards.body_guard import limited
from hslam_gvg.guards.ring_guard import RingGuardConfig
from hslam_gvg.local_graph import open_space
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.local_graph.local_graph import LocalGraph, local_graph
from hslam_gvg.ranging.local_map import LocalMap
from hslam_gvg.ranging.odometer import Odometer
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_gvg.ranging.scanned_map import ScannedMap
from hslam_gvg.ranging.sonar_map import SonarMap
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import OdometrySample, Velocity

NEAR_M = 0.8
"""Obstacles farther off do not matter to the next moves."""
FEW_POINTS = 4
"""Fewer obstacle points make no graph."""


class Surroundings:
    """Owns the local map; everything in the map's frame (m, rad): odom, but for what the map has corrected of it."""

    def __init__(self, config: FollowConfig, local_map: LocalMap, graph: LocalGraphConfig) -> None:
        """Begin with a map that knows nothing."""
        self._config, self._graph_config = config, graph
        self.map = local_map
        self._odometer = Odometer(config.metres_per_radian)
        self.pose = SE2()
        self.map_in_odom = SE2()
        """Where the map's frame is in odom: at its origin while the map has corrected nothing."""
        self.graph: LocalGraph | None = None
        """The reduced GVG as of the last look."""
        self.points: Array = np.zeros((0, 2))
        """The obstacle points as of the last look, n x 2."""
        self._open_space = open_space.NONE
        self._looked_m = -math.inf

    @property
    def travel_m(self) -> float:
        """The odometer's reading."""
        return self._odometer.travel_m

    @property
    def turned(self) -> float:
        """The angle (rad) turned so far, either way."""
        return self._odometer.turned

    @property
    def step_m(self) -> float:
        """Way driven in the last step."""
        return self._odometer.step_m

    def move(self, base_in_odom: SE2) -> None:
        """Take the robot's next pose by odometry; in the map it is where what was heard has put it."""
        self.pose = base_in_odom if self.map_in_odom == SE2() else self.map_in_odom.to(base_in_odom)
        self._odometer.move(base_in_odom)

    def hear(self, heard: Any, odom: OdometrySample, *, attentive: bool) -> None:
        """Take what the sensor said in one cycle; an attentive robot minds all of it, though it hardly moves."""
        here = dataclasses.replace(odom, base_in_odom=self.pose)
        pose = self.map.hear(heard, here, self.travel_m, attentive=attentive)
        if pose != self.pose:
            self.pose = pose
            self.map_in_odom = odom.base_in_odom @ pose.inverse()

    def in_map(self, x: float, y: float) -> tuple[float, float]:
        """Return a place in odom as one in the map."""
        return (x, y) if self.map_in_odom == SE2() else self.map_in_odom.inverse().apply(x, y)

    def points_in_odom(self) -> Array:
        """Return what is taken for obstacles, n x 2 (m, odom)."""
        points = self.map.obstacle_points()
        return points if self.map_in_odom == SE2() else self.map_in_odom.apply_all(points)

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
        self._open_space = self.map.open_space()
        if len(self.points) < FEW_POINTS:
            self.graph = None
            return
        x, y, _ = self.pose
        self.graph = local_graph(
            self.points, self.map.is_free, x, y, self._graph_config, self.map.gaps, self._open_space
        )

    def is_in_the_open(self) -> bool:
        """Whether the robot is in open space, by the last look: there is no graph to follow there."""
        return bool(self._open_space.holds(np.array([self.pose.x]), np.array([self.pose.y]))[0])

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
        """Return the obstacles that matter to the next moves: of the map, and of the latest answers."""
        x, y, _ = self.pose
        points = np.concatenate((self.points, self.map.recent()))
        return points[(np.abs(points[:, 0] - x) < NEAR_M) & (np.abs(points[:, 1] - y) < NEAR_M)]

    def limited(self, wanted: Velocity) -> tuple[Velocity, bool]:
        """Return the command that keeps the body off what is known or suspected, and whether it was stopped."""
        command, blocked = limited(wanted, self.pose, self.near(), self._config.body_m + self._config.margin_m)
        command, doubted = self.map.limited(command, self.pose, self.points)
        return command, blocked or doubted

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


def surroundings(
    config: FollowConfig,
    mapping: ScanMapConfig | SonarMapConfig,
    graph: LocalGraphConfig,
    guard: RingGuardConfig,
) -> Surroundings:
    """Return surroundings that know nothing yet; ``mapping`` tells by what sensor their map is drawn."""
    if isinstance(mapping, SonarMapConfig):
        return Surroundings(config, SonarMap(mapping, guard, config.body_m), graph)
    return Surroundings(config, ScannedMap(config, mapping), graph)
