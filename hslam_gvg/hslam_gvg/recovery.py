"""Where the way is shut: seen (blocked by the reflex or by caution) or felt (the body is held).

The robot steps back, the way that failed is remembered, and it takes another; where none is left, the edge ends.
"""

import math

from hslam_gvg.closest_points import closest_points
from hslam_gvg.homing import Homing
from hslam_gvg.motion import go_to
from hslam_gvg.reduced_graph import ReducedNode
from hslam_gvg.situation import Situation
from hslam_gvg.states import GvgState
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

PACE = 0.5
"""Share of the cruising speed for driving back, where only the trail is known to be free."""
NOT_BACK = math.radians(60.0)
"""A way less than this from where the robot came from leads back."""
TRIES = 3
"""So many ways are tried before the edge ends here."""
BACKING_S = 2.0
"""At that pace some 0.4 m: enough room to turn to another way."""
LEAF_M = 1.5
"""A dead end this near to where the way was blocked is what blocks it."""
LEAST_EDGE_M = 1.0
"""No end is announced on a shorter way: it would be the node just left, seen anew."""


class Recovery:
    """The states BACKING and RECOILING, and what leads to them."""

    def __init__(self, situation: Situation, homing: Homing) -> None:
        """Work on the situation shared by all states; ``homing`` ends an edge."""
        self._now, self._homing = situation, homing
        self._interrupted = GvgState.IDLE
        self._back_to = (0.0, 0.0)

    def give_way(self) -> Velocity:
        """Blocked while tracing: home on the dead end if the map shows one, else step back to choose again."""
        now = self._now
        leaf = now.local_graph().node_near(now.pose.x, now.pose.y, LEAF_M)
        now.obstructions.add(now.pose, now.pose.theta, now.map.travel_m)
        now.tries += 1
        if leaf is not None and leaf.degree == 1 and now.tries == 1:
            now.target = leaf
            now.enter(GvgState.HOMING)
        else:
            now.enter(GvgState.BACKING)
        return Velocity()

    def back_off(self) -> Velocity:
        """Step back from what blocks the way, then take one that is not blocked."""
        now = self._now
        if now.waited_s() < BACKING_S and not now.blocked:
            return Velocity(-now.pace(PACE), 0.0)
        self._take_another_way()
        return Velocity()

    def held(self, direction: float) -> None:
        """Something holds the body in its way (1 forwards, -1 backwards): remember it there and drive back."""
        now = self._now
        x, y, heading = now.pose
        now.map.touch(now.pose, direction)
        now.obstructions.add(now.pose, heading if direction > 0.0 else wrap(heading + math.pi), now.map.travel_m)
        if now.state is GvgState.RECOILING:
            self._recoiled()
            return
        self._interrupted = now.state
        self._back_to = now.trail.before(x, y, now.config.recoil_m)
        now.enter(GvgState.RECOILING)

    def recoil(self) -> Velocity:
        """Drive back along the trail, then let what was under way take note."""
        now = self._now
        if now.distance_m(*self._back_to) <= 2.0 * now.config.home_tolerance_m or now.stuck():
            self._recoiled()
            return Velocity()
        return go_to(now.pose, *self._back_to, now.pace(PACE), now.config.turn_rad_s)

    def _recoiled(self) -> None:
        now, state = self._now, self._interrupted
        if state in (GvgState.HOMING, GvgState.PROBING, GvgState.SETTLING):
            self._homing.give_up(state)
        elif state is GvgState.STRAIGHT:
            now.lose()
        elif state in (GvgState.TRACING, GvgState.RESUMING, GvgState.BACKING):
            now.tries += 1
            self._take_another_way()
        elif state is GvgState.ACCESSING and now.tries >= TRIES:
            now.lose()
        else:
            now.tries += 1
            now.enter(state)

    def _take_another_way(self) -> None:
        """Take a way that is not blocked; where none is left, the edge ends."""
        now = self._now
        x, y, heading = now.pose
        ways = now.ways()
        back = now.journey.came_from(x, y, now.config.chord_m)
        free = now.obstructions.free(ways, now.pose, now.map.travel_m)
        on = [way for way in free if back is None or abs(wrap(way - back)) > NOT_BACK]
        if on and now.tries <= TRIES:
            now.heading = min(on, key=lambda way: abs(wrap(way - heading)))
            now.enter(GvgState.RESUMING)
        elif back is not None and now.journey.length_m > LEAST_EDGE_M:
            self._homing.arrive(ReducedNode(x, y, self._clearance_m(), (back,)))
        else:
            now.lose()

    def _clearance_m(self) -> float:
        now, config = self._now, self._now.config
        near = closest_points(now.map.points(), now.pose.x, now.pose.y, config.reach_m, config.separation, most=1)
        return near[0].distance_m if near else config.body_m
