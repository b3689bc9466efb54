"""The rolling memory of obstacle points round the robot, in odom.

It forgets by distance travelled and turned, never by time: odometry drifts with motion.  "Nothing heard" is
no evidence of free space (specular walls do not answer), so nothing is ever carved away; but newer points
replace old ones beside them.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from hslam_gvg.arc import Arc, Arcs, Flags, median_azimuth, relate
from hslam_gvg.config import GvgConfig
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import SonarSweep

Rows = npt.NDArray[np.signedinteger[Any]]

UNRESOLVED, RESOLVED, FILL, EXPLAINED, WITHDRAWN = 0, 1, 2, 3, 4
"""Kinds of rows: an echo at its arc's centre, an echo placed by other arcs, wall between two echoes, an echo beside
a resolved one (an arc, no point), and a replaced one."""
CAPACITY = 2048
FILL_STEP_M = 0.12
"""Distance between the points that stand for a stretch of wall."""
CROSSING_RATE, LEAST_CROSSING = math.radians(9.0), math.radians(11.0)
"""Crossing angle needed by range (rad/m), and at least: range noise then moves the crossing by some 15 cm at most."""
SAME_PLACE_M = 0.05
SAME_AXIS = math.radians(4.0)
EXPLAINED_M = 0.2
"""An unresolved echo this near a resolved point is that obstacle's."""
WARY_M = 2.0
"""Such echoes from this near are kept clear of all the same."""
SUPPORT = 2
"""An obstacle has been heard more often than once or twice: other echoes lie beside it."""
CLUSTER = 3
UNRESOLVED_M = 1.2
"""Echoes that no second arc has placed are believed from this near only: most of them hang in mid-air."""
STALE_TRAVEL_M = 2.5
REPLACE_M = 0.25
PARTNER_POINTS_M = 1.2
LONGEST_TANGENT_M = 0.8
"""Echoes farther apart seldom belong to one stretch of wall."""
NEWEST_NORMALS = 9
"""How many of the newest partners vote."""


class ObstacleMap:
    """Takes odometry and pings, answers with obstacle points."""

    def __init__(self, config: GvgConfig) -> None:
        """Start empty."""
        self._config = config
        self.travel_m = 0.0
        """Odometer: metres plus turning, as the memory counts them."""
        self._pose: SE2 | None = None
        self._count = 0
        columns = np.zeros((8, CAPACITY))
        self._columns = columns
        self._x, self._y, self._axis, self._range = columns[0], columns[1], columns[2], columns[3]
        self._px, self._py, self._born, self._support = columns[4], columns[5], columns[6], columns[7]
        self._kind = np.zeros(CAPACITY, dtype=np.int64)
        self._cache: Array | None = None
        self._wary_cache: Array | None = None

    def move(self, base_in_odom: SE2) -> None:
        """Advance the odometer to a new pose."""
        last, self._pose = self._pose, base_in_odom
        if last is not None:
            turned = abs(wrap(base_in_odom.theta - last.theta))
            self.travel_m += math.hypot(base_in_odom.x - last.x, base_in_odom.y - last.y)
            self.travel_m += self._config.metres_per_radian * turned
        self._clear(base_in_odom.x, base_in_odom.y)
        self._forget()

    def hear(self, sweep: SonarSweep, poses: tuple[SE2, ...]) -> None:
        """Add a sweep's echoes; ``poses`` holds base_link in odom at each ping."""
        ring = sweep.ring
        for ping, pose in zip(sweep.pings, poses, strict=True):
            if not ring.range_min_m <= ping.range_m < ring.range_max_m:
                continue
            axis = pose.theta + ring.bearings[ping.sensor]
            x, y = pose.apply(
                ring.mount_radius_m * math.cos(ring.bearings[ping.sensor]),
                ring.mount_radius_m * math.sin(ring.bearings[ping.sensor]),
            )
            self.add(Arc(x, y, axis, ping.range_m), ring.cone_half_angle)

    def points(self) -> Array:
        """Return every point believed to be an obstacle (n x 2, m, odom); do not write into it."""
        if self._cache is None:
            self._cache = self._select(UNRESOLVED_M)
        return self._cache

    def suspects(self) -> Array:
        """Return the believed points and those that may yet prove obstacles, to keep clear of (n x 2, m, odom)."""
        if self._wary_cache is None:
            self._wary_cache = self._select(WARY_M)
        return self._wary_cache

    def _select(self, unresolved_m: float) -> Array:
        n = self._count
        kind, heard_often = self._kind[:n], self._support[:n] >= SUPPORT
        chosen = (kind == FILL) | (heard_often & (kind == RESOLVED))
        unresolved, heard_m = kind == UNRESOLVED, self._range[:n]
        chosen |= heard_often & unresolved & (heard_m < unresolved_m)
        # An edge seldom answers: a cluster of such echoes is one, even where no two arcs cross well enough.
        chosen |= (self._support[:n] >= CLUSTER) & unresolved & (heard_m < WARY_M)
        return np.column_stack((self._px[:n][chosen], self._py[:n][chosen]))

    def _changed(self) -> None:
        self._cache = self._wary_cache = None

    def add(self, arc: Arc, half_cone: float) -> None:
        """Place one echo by what the arcs in memory say about it."""
        config, n = self._config, self._count
        centre_x, centre_y = arc.point(arc.axis)
        recent = (
            (self._born[:n] > self.travel_m - config.partner_travel_m)
            & (self._kind[:n] != WITHDRAWN)
            & (self._kind[:n] != FILL)
            & (np.hypot(self._px[:n] - centre_x, self._py[:n] - centre_y) < PARTNER_POINTS_M)
        )
        rows = np.flatnonzero(recent)
        if self._repeats(arc, rows):
            return
        azimuth, kind = arc.axis, UNRESOLVED
        wall_partner, wall_normal = -1, 0.0
        if len(rows):
            old = Arcs(self._x[rows], self._y[rows], self._axis[rows], self._range[rows])
            crossing = min(config.crossing_angle, max(LEAST_CROSSING, CROSSING_RATE * arc.range_m))
            found = relate(arc, old, half_cone, crossing, config.wall_step_m)
            touches = found.touches & (found.wall_length < LONGEST_TANGENT_M)
            crossings, walls = int(found.crosses.sum()), int(touches.sum())
            if crossings > walls:
                azimuth, kind = median_azimuth(found.crossing[found.crosses], arc.axis), RESOLVED
                self._resolve(rows[found.crosses], found.crossing_on_old[found.crosses])
            elif walls > 1:
                normals = found.normal[touches][-NEWEST_NORMALS:]
                wall_normal = median_azimuth(normals, arc.axis)
                offset = min(max(wrap(wall_normal - arc.axis), -half_cone), half_cone)
                azimuth, kind = arc.axis + offset, RESOLVED
                near = touches & (
                    np.abs(np.remainder(found.normal - wall_normal + math.pi, 2 * math.pi) - math.pi) < 0.2
                )
                self._resolve(rows[near], self._clamped(rows[near], found.normal[near], half_cone))
                if near.any():
                    wall_partner = int(rows[near][-1])
        if kind == UNRESOLVED and arc.range_m > config.reach_m + 1.0:
            return
        x, y = arc.point(azimuth)
        self._insert(arc, x, y, kind)
        if wall_partner >= 0:
            self._fill(x, y, float(self._px[wall_partner]), float(self._py[wall_partner]))
        self._changed()

    def _repeats(self, arc: Arc, rows: Rows) -> bool:
        """Whether the same sonar has just said the same from the same place: standing still is no evidence."""
        if not len(rows):
            return False
        same = (
            (np.hypot(self._x[rows] - arc.x, self._y[rows] - arc.y) < SAME_PLACE_M)
            & (np.abs(np.remainder(self._axis[rows] - arc.axis + math.pi, 2.0 * math.pi) - math.pi) < SAME_AXIS)
            & (np.abs(self._range[rows] - arc.range_m) < SAME_PLACE_M)
        )
        if not same.any():
            return False
        again = rows[same]
        self._support[again] += 1.0
        self._born[again] = self.travel_m
        self._changed()
        return True

    def _clamped(self, rows: Rows, normals: Array, half_cone: float) -> Array:
        axis = self._axis[rows]
        offset = np.remainder(normals - axis + math.pi, 2.0 * math.pi) - math.pi
        clamped: Array = axis + np.clip(offset, -half_cone, half_cone)
        return clamped

    def _resolve(self, rows: Rows, azimuths: Array) -> None:
        """Move older unresolved echoes to where the new arc places them."""
        fresh = (self._kind[rows] == UNRESOLVED) | (self._kind[rows] == EXPLAINED)
        rows, azimuths = rows[fresh], azimuths[fresh]
        self._px[rows] = self._x[rows] + self._range[rows] * np.cos(azimuths)
        self._py[rows] = self._y[rows] + self._range[rows] * np.sin(azimuths)
        self._kind[rows] = RESOLVED

    def _insert(self, arc: Arc, x: float, y: float, kind: int) -> None:
        n = self._count
        if n == CAPACITY:
            self._keep(np.arange(n) >= n // 4)
            n = self._count
        distance = np.hypot(self._px[:n] - x, self._py[:n] - y)
        kinds = self._kind[:n]
        alive = kinds != WITHDRAWN
        near = alive & (distance < self._config.speckle_m)
        self._support[:n][near] += 1.0
        solid = (kinds == RESOLVED) | (kinds == FILL)
        if kind == RESOLVED:
            stale = self._born[:n] < self.travel_m - STALE_TRAVEL_M
            kinds[alive & stale & (distance < REPLACE_M)] = WITHDRAWN
            kinds[(kinds == UNRESOLVED) & (distance < EXPLAINED_M)] = EXPLAINED
        elif (solid & (distance < EXPLAINED_M)).any():
            kind = EXPLAINED
        self._columns[:, n] = (arc.x, arc.y, arc.axis, arc.range_m, x, y, self.travel_m, float(near.sum()))
        self._kind[n] = kind
        self._count = n + 1

    def _fill(self, x: float, y: float, to_x: float, to_y: float) -> None:
        """Put points between two echoes of one wall."""
        length = math.hypot(to_x - x, to_y - y)
        if not FILL_STEP_M < length < self._config.wall_fill_m:
            return
        steps = int(length / FILL_STEP_M)
        for i in range(1, steps + 1):
            share = i / (steps + 1)
            px, py = x + share * (to_x - x), y + share * (to_y - y)
            n = self._count
            if n == CAPACITY:
                return
            beside = (np.abs(self._px[:n] - px) < 0.5 * FILL_STEP_M) & (np.abs(self._py[:n] - py) < 0.5 * FILL_STEP_M)
            solid = (self._kind[:n] == RESOLVED) | (self._kind[:n] == FILL)
            if not (beside & solid).any():
                self._columns[:, n] = (px, py, 0.0, 0.0, px, py, self.travel_m, 1.0)
                self._kind[n] = FILL
                self._count = n + 1

    def _clear(self, x: float, y: float) -> None:
        """Withdraw what the body stands in: nothing was there."""
        n = self._count
        under = (np.hypot(self._px[:n] - x, self._py[:n] - y) < self._config.body_m) & (self._kind[:n] != WITHDRAWN)
        if under.any():
            self._kind[:n][under] = WITHDRAWN
            self._changed()

    def _forget(self) -> None:
        n = self._count
        kept = (self._born[:n] > self.travel_m - self._config.memory_m) & (self._kind[:n] != WITHDRAWN)
        if n - int(kept.sum()) > 32:
            self._keep(kept)

    def _keep(self, kept: Flags) -> None:
        n = int(kept.sum())
        self._columns[:, :n] = self._columns[:, : self._count][:, kept]
        self._kind[:n] = self._kind[: self._count][kept]
        self._count = n
        self._changed()
