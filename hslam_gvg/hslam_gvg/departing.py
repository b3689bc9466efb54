"""Setting out: turning on the spot to a branch of the node, or to go on along the edge under way."""

import math

from hslam_gvg.motion import turn_to
from hslam_gvg.situation import Situation
from hslam_gvg.states import GvgError, GvgState
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

ALIGNED = math.radians(3.0)
"""A branch is faced within this; a meter on, the robot is then some 5 cm off it."""


class Departing:
    """The states TURNING and RESUMING."""

    def __init__(self, situation: Situation) -> None:
        """Work on the situation shared by all states."""
        self._now = situation
        self._branch = -1

    def check(self, branch: int) -> None:
        """Raise GvgError for a branch that the node stood at does not have."""
        node = self._now.node
        if node is None:
            raise GvgError("cannot trace an edge: the robot is at no node (give the goal 'access' first)")
        if not 0 <= branch < node.degree:
            raise GvgError(f"the node has no branch {branch}, only 0 to {node.degree - 1}")

    def choose(self, branch: int) -> None:
        """Take the branch to depart by; raises GvgError for one that the node stood at does not have."""
        self.check(branch)
        self._branch = branch
        self._now.enter(GvgState.TURNING)

    def turn(self) -> Velocity:
        """Turn to the branch to depart by, and depart."""
        now, node = self._now, self._now.node
        if node is None:
            raise GvgError("the node to depart from is gone: give the goal 'access'")
        bearing = node.bearings_in_odom[self._branch]
        if abs(wrap(bearing - now.pose.theta)) > ALIGNED:
            return self._turn(bearing)
        now.announcements.depart(node, self._branch)
        now.handled = [(node.x_in_odom, node.y_in_odom, now.map.travel_m + now.config.suppress_travel_m)]
        now.doubts.clear()
        now.node = None
        now.heading = bearing
        now.journey.begin(now.pose.x, now.pose.y)
        now.tries = 0
        now.enter(GvgState.TRACING)
        return Velocity()

    def resume(self) -> Velocity:
        """Turn to go on along the edge under way."""
        now = self._now
        if abs(wrap(now.heading - now.pose.theta)) > ALIGNED:
            return self._turn(now.heading)
        now.journey.resume(now.pose.x, now.pose.y)
        now.enter(GvgState.TRACING)
        return Velocity()

    def _turn(self, heading: float) -> Velocity:
        """Turn to a direction (rad); a base that does not come round to it is lost."""
        now = self._now
        if now.stuck():
            now.lose()
            return Velocity()
        return turn_to(now.pose, heading, now.config.turn_rad_s)
