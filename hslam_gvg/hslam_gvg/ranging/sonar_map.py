"""The local map that sonars draw: reflectors where echoes agree, free space where cones were silent, ways pings went.

A cone nearer than its echo is free; silence beyond shows nothing, for walls met askew do not answer.  Where the body
has been nothing is, whatever echoes say.
"""

import math
from collections import deque

import numpy as np

from hslam_gvg.guards.ring_guard import RingGuard, RingGuardConfig
from hslam_gvg.guards.wariness import wary
from hslam_gvg.local_graph import open_space
from hslam_gvg.local_graph.gaps import OPEN, SHUT, UNKNOWN, Gaps
from hslam_gvg.local_graph.open_space import OpenSpace
from hslam_gvg.ranging.cone_ping import ConePing, PingPlaces, cone_pings
from hslam_gvg.ranging.ping_memory import CORE, PingMemory
from hslam_gvg.ranging.reflectors import Reflectors
from hslam_gvg.ranging.rolling_grid import Mask, RollingGrid
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import OdometrySample, SonarSweep, Velocity

SHORT_OF_ECHO_M, LEAST_FREE_M = 0.12, 0.05
"""Free space ends so much before the echo that bounds it; shorter cones show nothing."""
THROUGH_SHARE = 0.3
"""Of the pings that met a gap so many went through if it is one: the others hear its jambs; a wall is missed seldom."""
CORNERS = math.sqrt(2.0)
"""A square about the body has its corners so many radii from the centre."""
TRODDEN_STEP_M = 0.1
"""Spacing of the places where the body has been."""
FORGET_EVERY_M = 0.25
"""Travel between two times of forgetting: each costs a pass over the grid."""


class SonarMap:
    """A `hslam_gvg.ranging.local_map.LocalMap` by sweeps of sonars."""

    def __init__(self, config: SonarMapConfig, guard: RingGuardConfig, body_m: float) -> None:
        """Begin with nothing known; ``body_m`` is the radius of the body."""
        self._config, self._body_m = config, body_m
        self._guard = RingGuard(guard, body_m)
        self._places = PingPlaces()
        self._pings = PingMemory(config.memory_m)
        self._reflectors = Reflectors(config.reach_m, config.memory_m, config.support)
        self._grid = RollingGrid(config.cell_m, max(config.reach_m, config.free_reach_m) + config.margin_m)
        self._forgot_m = 0.0
        self._odometer_m = 0.0
        self._trodden: deque[tuple[float, float, float]] = deque()
        self._touched: list[tuple[float, float, float]] = []

    def hear(self, heard: SonarSweep, odom: OdometrySample, odometer_m: float, *, attentive: bool) -> SE2:
        """Take a sweep; what it repeats is no evidence, so that an attentive robot hears no more than another."""
        del attentive
        self._odometer_m = odometer_m
        base = odom.base_in_odom
        self._grid.follow(base.x, base.y)
        if odometer_m - self._forgot_m > FORGET_EVERY_M:
            self._forgot_m = odometer_m
            self._grid.forget_before(odometer_m - self._config.memory_m)
        self._tread(base)
        bases = self._places.of(heard, odom)
        pings = cone_pings(heard, bases)
        unexplained = np.flatnonzero(~self._reflectors.explains(pings)).tolist()
        self._guard.hear(heard, bases, base, unexplained)
        for ping in pings:
            self._hear(ping)
        return base

    def touch(self, x: float, y: float, odometer_m: float) -> None:
        """Note an obstacle that the body met and no sonar heard."""
        self._touched.append((x, y, odometer_m))

    def obstacle_points(self) -> Array:
        """Return what is taken for obstacles, n x 2."""
        points = self._reflectors.points(self._odometer_m)
        if len(points) and self._trodden:
            trodden = np.array(self._trodden)
            away = np.hypot(points[:, 0, None] - trodden[:, 0], points[:, 1, None] - trodden[:, 1]).min(axis=1)
            points = points[away >= self._body_m]
        kept_m = self._odometer_m - self._config.touch_memory_m
        self._touched = [place for place in self._touched if place[2] > kept_m]
        return np.concatenate((points, np.array([place[:2] for place in self._touched]).reshape(-1, 2)))

    def is_free(self, x: Array, y: Array) -> Mask:
        """Return which points lie in cells known to be free."""
        return self._grid.is_free(x, y)

    def open_space(self) -> OpenSpace:
        """Return none: silence shows nothing, so that no place is known to be far from walls."""
        return open_space.NONE

    def gaps(self, begin: Array, end: Array) -> Gaps:
        """Return which gaps are open: those pings went through, and wide ones; where pings ended they are shut."""
        known = np.full(len(begin), OPEN, np.int8)
        width = np.hypot(*(end - begin).T)
        asked = np.flatnonzero(width < max(self._config.doubtful_m, self._config.refuted_m))
        if len(asked):
            through, ended = self._pings.met(begin[asked], end[asked], self._odometer_m)
            least = self._config.gap_pings
            is_open = (through >= least) & (through >= THROUGH_SHARE * (through + ended))
            unheard = np.where(width[asked] < self._config.doubtful_m, UNKNOWN, OPEN)
            known[asked] = np.where(is_open, OPEN, np.where(ended >= least, SHUT, unheard))
        return known

    def recent(self) -> Array:
        """Return nothing: single echoes bound the pace (`limited`), but are no obstacles yet."""
        return np.zeros((0, 2))

    def limited(self, wanted: Velocity, base_in_odom: SE2, obstacles: Array) -> tuple[Velocity, bool]:
        """Return the command that the latest echoes, and where was listened, allow, and whether it was stopped."""
        command, stopped = self._guard.limited(wanted, base_in_odom, obstacles)
        return wary(command, base_in_odom, self._reflectors.suspects(self._odometer_m), self._body_m), stopped

    def _hear(self, ping: ConePing) -> None:
        self._free(ping)
        if self._pings.is_new(ping, self._odometer_m):
            self._reflectors.weigh(self._pings.newest())
            self._reflectors.add(ping, self._pings.recent(self._odometer_m), self._odometer_m)

    def _free(self, ping: ConePing) -> None:
        reach = min(ping.range_m - SHORT_OF_ECHO_M, self._config.free_reach_m)
        if reach > LEAST_FREE_M:
            azimuth = ping.axis + CORE * ping.half_cone * np.linspace(-1.0, 1.0, 5)
            rim = np.column_stack((ping.x + reach * np.cos(azimuth), ping.y + reach * np.sin(azimuth)))
            self._grid.free_inside(np.vstack(((ping.x, ping.y), rim)), self._odometer_m)

    def _tread(self, base: SE2) -> None:
        x, y, _ = base
        out = CORNERS * self._body_m
        corners = np.array([(x - out, y), (x, y - out), (x + out, y), (x, y + out)])
        last = self._trodden[-1] if self._trodden else (math.inf, math.inf, 0.0)
        if math.hypot(x - last[0], y - last[1]) > TRODDEN_STEP_M:
            self._trodden.append((x, y, self._odometer_m))
            self._grid.free_inside(corners, self._odometer_m)
        while self._trodden and self._trodden[0][2] < self._odometer_m - self._config.trodden_m:
            self._trodden.popleft()
