"""How far the robot has travelled: what every memory of the surroundings is measured in, because odometry drifts."""

import math

from hslam_types.se2 import SE2, wrap


class Odometer:
    """Adds up the way of base_link in odom; a turn counts too, at so many metres a radian."""

    def __init__(self, metres_per_radian: float) -> None:
        """Begin at zero."""
        self._metres_per_radian = metres_per_radian
        self._last: SE2 | None = None
        self.travel_m = 0.0
        """Way driven and turned so far."""
        self.step_m = 0.0
        """Way driven in the last step, turning left out."""
        self.turned = 0.0
        """Angle (rad) turned so far, either way."""

    def move(self, base_in_odom: SE2) -> None:
        """Take the next pose."""
        last, self._last = self._last, base_in_odom
        if last is None:
            return
        self.step_m = math.hypot(base_in_odom.x - last.x, base_in_odom.y - last.y)
        turned = abs(wrap(base_in_odom.theta - last.theta))
        self.turned += turned
        self.travel_m += self.step_m + self._metres_per_radian * turned
