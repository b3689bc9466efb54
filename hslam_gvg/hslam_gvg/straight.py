"""A straight drive to a point nearer than any obstacle, off the GVG."""

import math

from hslam_gvg.motion import go_to
from hslam_gvg.situation import STUCK_S, Situation
from hslam_gvg.states import GvgError, GvgState
from hslam_types.sensing import Velocity

PACE = 0.8
"""Share of the cruising speed: beside the GVG obstacles are nearer."""


class Straight:
    """The state STRAIGHT."""

    def __init__(self, situation: Situation) -> None:
        """Work on the situation shared by all states."""
        self._now = situation
        self._goal = (0.0, 0.0)

    def check(self, x: float, y: float) -> None:
        """Raise GvgError for a target that is no point."""
        if not (math.isfinite(x) and math.isfinite(y)):
            raise GvgError(f"cannot drive to ({x}, {y}): the target must be finite")

    def begin(self, x: float, y: float) -> None:
        """Take the point to drive to (m, odom)."""
        self._now.node = None
        self._goal = (x, y)
        self._now.enter(GvgState.STRAIGHT)

    def distance_left_m(self) -> float:
        """Return the distance to the point to drive to."""
        return self._now.distance_m(*self._goal)

    def drive(self) -> Velocity:
        """Drive there; idle when there, lost when something stands in the way."""
        now = self._now
        if self.distance_left_m() <= now.config.home_tolerance_m:
            now.enter(GvgState.IDLE)
            return Velocity()
        if now.blocked_s() > STUCK_S:
            now.lose()
            return Velocity()
        return go_to(now.pose, *self._goal, now.pace(PACE), now.config.turn_rad_s)
