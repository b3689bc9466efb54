"""Tracing: along the edge, two obstacles equally far, until a node of the local graph is reached or passed."""

import math

from hslam_gvg.closest_points import ahead, beside
from hslam_gvg.control import drive, follow, trace
from hslam_gvg.recovery import Recovery
from hslam_gvg.situation import STUCK_S, Situation
from hslam_gvg.states import GvgState
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

LOOK_AFTER_S = 1.0
"""Blocked for so long, the robot looks for a node at once."""
COURSE_BACK_M = 1.0
"""The course is the direction of the last so many metres."""
NOT_BACK = math.radians(60.0)
"""A way less than this from where the robot came from leads back."""
LEAVING_M = 1.0
"""Within this of the node left, the branch departed by is the course."""
SHARPEST_TURN = math.radians(120.0)
"""An edge turns less than this between two looks; more would be another edge."""
STRIP_HALF_M, STRIP_M, FREE_M, LEAST_SHARE = 0.3, 2.0, 1.6, 0.35
"""Slower, down to a share, where less than `FREE_M` of the strip ahead is free."""
OPENING, SLOWING, SLOWEST = 1.12, 2.5, 0.2
"""Where the clearance grows by more than a factor a side opens: slower, the edge at its far end answers seldom."""
WIDER, NARROWER = 0.006, 0.05
"""Shares of the usual clearance renewed at each step."""


class Tracing:
    """The state TRACING."""

    def __init__(self, situation: Situation, recovery: Recovery) -> None:
        """Work on the situation shared by all states; ``recovery`` takes over where the way is blocked."""
        self._now, self._recovery = situation, recovery

    def follow(self) -> Velocity:
        """Follow two-way equidistance; look for nodes every so often, and at once where the way is blocked."""
        now = self._now
        now.journey.advance(now.pose.x, now.pose.y)
        due = now.map.travel_m - now.looked_m >= now.config.look_every_m
        if (due or now.blocked_s() > LOOK_AFTER_S) and self._look():
            return Velocity()
        if now.blocked_s() > STUCK_S:
            return self._recovery.give_way()
        return self._along_edge()

    def _look(self) -> bool:
        """Look at the local graph for a node on the recent path; begin homing on it."""
        now = self._now
        x, y, heading = now.pose
        now.looked_m = now.map.travel_m
        now.handled = [h for h in now.handled if now.map.travel_m < h[2]]
        graph = now.local_graph()
        # At the node just left every branch passes by; which one was meant is what the departure said.
        leaving = now.journey.length_m < LEAVING_M
        now.course = now.heading if leaving else self._way_on(graph.passing(x, y))
        node = now.detector.passed(graph, now.pose, now.journey.places(), [h[:2] for h in now.handled])
        if node is None:
            return False
        now.target = now.detector.homed(now.map.points(), node)
        now.journey.rewind(node.x, node.y)
        now.heading = heading
        now.tries = 0
        now.enter(GvgState.HOMING)
        return True

    def _way_on(self, ways: tuple[float, ...]) -> float | None:
        """Return the direction in which the local graph leads on: the one nearest to the heading, but not back."""
        x, y, heading = self._now.pose
        back = self._now.journey.came_from(x, y, COURSE_BACK_M)
        on = [way for way in ways if back is None or abs(wrap(way - back)) > NOT_BACK]
        return min(on, key=lambda way: abs(wrap(way - heading)), default=None)

    def _along_edge(self) -> Velocity:
        now, config, points = self._now, self._now.config, self._now.map.suspects()
        x, y, heading = now.pose
        if now.course is not None and abs(wrap(now.course - heading)) < SHARPEST_TURN:
            # Seen along the way the graph takes, a wall across the end of a corridor is on one side, not ahead.
            heading = now.course
        left, right = beside(points, x, y, heading, config.reach_m)
        near = [side for side in (left, right) if side is not None]
        room_m = min((side.distance_m for side in near), default=config.wide_m)
        free_m = ahead(points, x, y, heading, STRIP_HALF_M, STRIP_M)
        speed = config.cruise_m_s * min(1.0, max(LEAST_SHARE, free_m / FREE_M)) * self._opening(room_m)
        beta = config.equidistance_gain
        if left is not None and right is not None and room_m < config.wide_m:
            vx, vy = trace(left, right, heading, speed, beta)
        elif near:
            wall = min(near, key=lambda side: side.distance_m)
            vx, vy = follow(wall, config.wide_m, heading, speed, beta)
        else:
            vx, vy = speed * math.cos(heading), speed * math.sin(heading)
        share = min(1.0, speed / max(math.hypot(vx, vy), 1e-9))
        return drive(now.pose, vx * share, vy * share, config.turn_rad_s)

    def _opening(self, room_m: float) -> float:
        """Return the share of the speed that a clearance allows, by what is usual on this edge."""
        now = self._now
        share = min(1.0, max(SLOWEST, 1.0 - SLOWING * (room_m / now.room_m - OPENING)))
        now.room_m += (WIDER if room_m > now.room_m else NARROWER) * (room_m - now.room_m)
        return share
