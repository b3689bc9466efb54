"""Access: from anywhere onto the GVG (climb d_1 until a second obstacle is as far)."""

import math

from hslam_gvg.closest_points import closest_points
from hslam_gvg.control import access, drive
from hslam_gvg.situation import Situation
from hslam_gvg.states import GvgState
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

FIRST_SWEEP_S = 1.2
"""Longer than a sweep of all sixteen sonars takes; no way is taken before each has answered."""
OPEN_S = 5.0
"""The first echoes are placed on the move; where there are none after so long, the place is wide open."""
EQUAL_M = 0.1
"""Two obstacles are as far from each other as from here."""


class Accessing:
    """The states LISTENING and ACCESSING."""

    def __init__(self, situation: Situation) -> None:
        """Work on the situation shared by all states."""
        self._now = situation
        self.way: float | None = None
        """The direction to follow the GVG in (rad, odom), None for that of the robot."""

    def listen(self) -> Velocity:
        """Wait for a first full sweep before moving."""
        now = self._now
        if now.waited_s() >= FIRST_SWEEP_S:
            now.tries = 0
            now.enter(GvgState.ACCESSING)
        return Velocity()

    def climb(self) -> Velocity:
        """Go away from the nearest obstacle until a second is as far, or none is near."""
        now, config = self._now, self._now.config
        x, y, heading = now.pose
        near = closest_points(now.map.points(), x, y, config.reach_m, config.separation, most=2)
        room_m = near[0].distance_m if near else math.inf
        now.room_m = min(room_m, config.wide_m)
        if not near and now.waited_s() < OPEN_S:
            return Velocity(now.pace(0.5), 0.0)
        equal = len(near) > 1 and near[1].distance_m - room_m < EQUAL_M
        if equal or room_m >= config.wide_m or now.stuck():
            return self._accessed()
        backwards = abs(wrap(near[0].bearing - heading)) < 0.5 * math.pi
        return drive(now.pose, *access(near[0], now.pace(0.5)), config.turn_rad_s, backwards=backwards)

    def _accessed(self) -> Velocity:
        """Announce the GVG and follow it the way that is nearer to the one asked for, else to the heading."""
        now = self._now
        x, y, facing = now.pose
        heading = facing if self.way is None else self.way
        ways = now.ways()
        free = now.obstructions.free(ways, now.pose, now.map.travel_m)
        now.heading = min(free or ways, key=lambda way: abs(wrap(way - heading)), default=heading)
        now.journey.begin(x, y)
        now.tries = 0
        now.announcements.access()
        now.enter(GvgState.RESUMING)
        return Velocity()
