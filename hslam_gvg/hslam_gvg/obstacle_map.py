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
from hslam_types.se2 import SE2, Array, wrap, wrap_all
from hslam_types.sensing import SonarSweep

Rows = npt.NDArray[np.signedinteger[Any]]

UNRESOLVED, RESOLVED, FILL, EXPLAINED, WITHDRAWN = 0, 1, 2, 3, 4
"""Kinds of rows: an echo at its arc's centre, an echo placed by other arcs, wall between two echoes or touched by the
body, an echo beside a resolved one (an arc, no point), and a replaced one."""
TIDY_EVERY_M = 0.05
"""Travel between two times of forgetting: each costs a pass over all rows."""
SAME_NORMAL = 0.2
"""Directions (rad) of one wall by two partners; more than noise of 1 % in range makes of them."""
CAPACITY = 2048
"""Rows; where a slow robot hears more, the oldest quarter goes."""
FILL_STEP_M = 0.12
"""Distance between the points that stand for a stretch of wall."""
TOUCHED = (-0.5, 0.0, 0.5)
"""Directions (rad from the way) of the points that stand for what the body has touched."""
TOUCH_SLACK_M = 0.03
"""What was touched lies so far outside the body's circle, by what odometry may be wrong."""
CROSSING_RATE, LEAST_CROSSING = math.radians(9.0), math.radians(11.0)
"""Crossing angle needed by range (rad/m), and at least: range noise then moves the crossing by some 15 cm at most."""
SAME_PLACE_M = 0.05
"""A ping from within this of an older one, with a range as near, hears nothing new,"""
SAME_AXIS = math.radians(4.0)
"""and within this of its axis."""
EXPLAINED_M = 0.2
"""An unresolved echo this near a resolved point is that obstacle's."""
WARY_M = 2.0
"""Such echoes from this near are kept clear of all the same."""
SUPPORT = 2
"""An obstacle has been heard more often than once or twice: other echoes lie beside it."""
WARY_SUPPORT = 1
"""Two echoes of one place are enough to keep clear of it."""
CLUSTER = 3
"""So many echoes beside one another are an obstacle although none is placed."""
UNRESOLVED_M = 1.2
"""Echoes that no second arc has placed are believed from this near only: most of them hang in mid-air."""
STALE_TRAVEL_M = 2.5
"""After so much travel odometry has drifted enough for a newer echo to be right instead,"""
REPLACE_M = 0.25
"""where it lies this near."""
PARTNER_POINTS_M = 1.2
"""Arcs with points farther apart seldom cross: the widest cone is 0.8 m wide at 3 m."""
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
        self._tidied_m = 0.0
        self._pose: SE2 | None = None
        self._count = 0
        columns = np.zeros((8, CAPACITY))
        self._columns = columns
        self._x, self._y, self._axis, self._range = columns[0], columns[1], columns[2], columns[3]
        self._px, self._py, self._born, self._support = columns[4], columns[5], columns[6], columns[7]
        self._kind = np.zeros(CAPACITY, dtype=np.int64)
        self._is_arc = np.array([True, True, False, True, False])
        self._is_solid = np.array([False, True, True, False, False])
        self._cache: Array | None = None
        self._wary_cache: Array | None = None

    def move(self, base_in_odom: SE2) -> None:
        """Advance the odometer to a new pose."""
        last, self._pose = self._pose, base_in_odom
        if last is not None:
            turned = abs(wrap(base_in_odom.theta - last.theta))
            self.travel_m += math.hypot(base_in_odom.x - last.x, base_in_odom.y - last.y)
            self.travel_m += self._config.metres_per_radian * turned
        if self.travel_m - self._tidied_m > TIDY_EVERY_M:
            self._tidied_m = self.travel_m
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

    def touch(self, base_in_odom: SE2, direction: float) -> None:
        """Believe in an obstacle at the body's rim, where the way (1 forwards, -1 backwards) was stopped."""
        way = base_in_odom.theta + (0.0 if direction > 0.0 else math.pi)
        azimuths = way + np.array(TOUCHED)
        reach_m = self._config.body_m + TOUCH_SLACK_M
        n = self._count
        if n + len(azimuths) > CAPACITY:
            self._keep(np.arange(n) >= n // 4)
            n = self._count
        end = n + len(azimuths)
        self._columns[:, n:end] = 0.0
        self._px[n:end] = base_in_odom.x + reach_m * np.cos(azimuths)
        self._py[n:end] = base_in_odom.y + reach_m * np.sin(azimuths)
        self._born[n:end] = self.travel_m
        self._kind[n:end] = FILL
        self._count = end
        self._changed()

    def points(self) -> Array:
        """Return every point believed to be an obstacle (n x 2, m, odom); do not write into it."""
        if self._cache is None:
            self._cache = self._select(UNRESOLVED_M, SUPPORT)
        return self._cache

    def suspects(self) -> Array:
        """Return the believed points and those that may yet prove obstacles, to keep clear of (n x 2, m, odom)."""
        if self._wary_cache is None:
            self._wary_cache = self._select(WARY_M, WARY_SUPPORT)
        return self._wary_cache

    def _select(self, unresolved_m: float, support: int) -> Array:
        n = self._count
        kind, heard = self._kind[:n], self._support[:n]
        unresolved, heard_m = kind == UNRESOLVED, self._range[:n]
        chosen = (kind == RESOLVED) | (unresolved & (heard_m < unresolved_m))
        chosen &= heard >= support
        if unresolved_m < WARY_M or support > CLUSTER:
            # An edge seldom answers: a cluster of such echoes is one, even where no two arcs cross well enough.
            chosen |= (heard >= CLUSTER) & unresolved & (heard_m < WARY_M)
        chosen |= kind == FILL
        return self._columns[4:6, :n].compress(chosen, axis=1).T

    def _changed(self) -> None:
        self._cache = self._wary_cache = None

    def add(self, arc: Arc, half_cone: float) -> None:
        """Place one echo by what the arcs in memory say about it."""
        rows = self._partners(arc)
        if self._repeats(arc, rows):
            return
        azimuth, kind, wall = self._placed(arc, rows, half_cone) if len(rows) else (arc.axis, UNRESOLVED, None)
        if kind == UNRESOLVED and arc.range_m > self._config.reach_m + 1.0:
            return
        x, y = arc.point(azimuth)
        self._insert(arc, x, y, kind)
        if wall is not None:
            self._fill(x, y, float(self._px[wall]), float(self._py[wall]))
        self._changed()

    def _partners(self, arc: Arc) -> Rows:
        """Return the rows whose arcs may have to do with a new one."""
        n, (x, y) = self._count, arc.point(arc.axis)
        dx, dy = self._px[:n] - x, self._py[:n] - y
        near = dx * dx + dy * dy < PARTNER_POINTS_M * PARTNER_POINTS_M
        near &= self._born[:n] > self.travel_m - self._config.partner_travel_m
        near &= self._is_arc[self._kind[:n]]
        rows: Rows = near.nonzero()[0]
        return rows

    def _placed(self, arc: Arc, rows: Rows, half_cone: float) -> tuple[float, int, int | None]:
        """Return a new arc's azimuth, its kind, and the newest row on the same wall, by vote of the older arcs."""
        config = self._config
        old = Arcs(self._x[rows], self._y[rows], self._axis[rows], self._range[rows])
        crossing = min(config.crossing_angle, max(LEAST_CROSSING, CROSSING_RATE * arc.range_m))
        found = relate(arc, old, half_cone, crossing, config.wall_step_m)
        touches = found.touches & (found.wall_length < LONGEST_TANGENT_M)
        crossings, walls = np.count_nonzero(found.crosses), np.count_nonzero(touches)
        if crossings > walls:
            self._resolve(rows[found.crosses], found.crossing_on_old[found.crosses])
            return median_azimuth(found.crossing[found.crosses], arc.axis), RESOLVED, None
        if walls < 2:
            return arc.axis, UNRESOLVED, None
        normal = median_azimuth(found.normal[touches][-NEWEST_NORMALS:], arc.axis)
        agreeing = touches & (np.abs(wrap_all(found.normal - normal)) < SAME_NORMAL)
        same_wall = rows[agreeing]
        axes = self._axis[same_wall]
        offsets = wrap_all(found.normal[agreeing] - axes)
        # Where the normal lies beside the cone, the cone's edge has heard the wall.
        self._resolve(same_wall, axes + np.clip(offsets, -half_cone, half_cone))
        azimuth = arc.axis + min(max(wrap(normal - arc.axis), -half_cone), half_cone)
        return azimuth, RESOLVED, int(same_wall[-1]) if len(same_wall) else None

    def _repeats(self, arc: Arc, rows: Rows) -> bool:
        """Whether the same sonar has just said the same from the same place: standing still is no evidence."""
        rows = rows[np.abs(self._range[rows] - arc.range_m) < SAME_PLACE_M]
        if not len(rows):
            return False
        rows = rows[np.abs(self._x[rows] - arc.x) + np.abs(self._y[rows] - arc.y) < SAME_PLACE_M]
        if not len(rows):
            return False
        again = rows[np.abs(wrap_all(self._axis[rows] - arc.axis)) < SAME_AXIS]
        if not len(again):
            return False
        self._support[again] += 1.0
        self._born[again] = self.travel_m
        self._changed()
        return True

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
        dx, dy = self._px[:n] - x, self._py[:n] - y
        squared = dx * dx + dy * dy
        near = (squared < self._config.speckle_m * self._config.speckle_m).nonzero()[0]
        near = near[self._kind[near] != WITHDRAWN]
        squared, kinds = squared[near], self._kind[near]
        self._support[near] += 1.0
        if kind == RESOLVED:
            stale = self._born[near] < self.travel_m - STALE_TRAVEL_M
            kinds[(kinds == UNRESOLVED) & (squared < EXPLAINED_M * EXPLAINED_M)] = EXPLAINED
            kinds[stale & (squared < REPLACE_M * REPLACE_M)] = WITHDRAWN
            self._kind[near] = kinds
        elif (self._is_solid[kinds] & (squared < EXPLAINED_M * EXPLAINED_M)).any():
            kind = EXPLAINED
        self._columns[:, n] = (arc.x, arc.y, arc.axis, arc.range_m, x, y, self.travel_m, float(len(near)))
        self._kind[n] = kind
        self._count = n + 1

    def _fill(self, x: float, y: float, to_x: float, to_y: float) -> None:
        """Put points between two echoes of one wall, where there are none."""
        n, length = self._count, math.hypot(to_x - x, to_y - y)
        steps = int(length / FILL_STEP_M)
        if not FILL_STEP_M < length < self._config.wall_fill_m or n + steps > CAPACITY:
            return
        share = np.arange(1, steps + 1) / (steps + 1)
        px, py = x + share * (to_x - x), y + share * (to_y - y)
        solid = (self._is_solid[self._kind[:n]] & (np.abs(self._px[:n] - x) < 2.0 * length)).nonzero()[0]
        dx, dy = np.abs(px[:, None] - self._px[solid]), np.abs(py[:, None] - self._py[solid])
        bare = ~(np.maximum(dx, dy) < 0.5 * FILL_STEP_M).any(axis=1)
        end = n + int(np.count_nonzero(bare))
        self._columns[:, n:end] = 0.0
        self._px[n:end], self._py[n:end], self._born[n:end] = px[bare], py[bare], self.travel_m
        self._kind[n:end] = FILL
        self._count = end

    def _clear(self, x: float, y: float) -> None:
        """Withdraw what the body stands in: nothing was there."""
        n = self._count
        dx, dy = self._px[:n] - x, self._py[:n] - y
        under = dx * dx + dy * dy < self._config.body_m * self._config.body_m
        if under.any():
            self._kind[:n][under] = WITHDRAWN
            self._changed()

    def _forget(self) -> None:
        n = self._count
        kept = (self._born[:n] > self.travel_m - self._config.memory_m) & (self._kind[:n] != WITHDRAWN)
        if not kept.all():
            self._keep(kept)

    def _keep(self, kept: Flags) -> None:
        n = int(kept.sum())
        self._columns[:, :n] = self._columns[:, : self._count][:, kept]
        self._kind[:n] = self._kind[: self._count][kept]
        self._count = n
        self._changed()
