"""The probing steps at a meet point: a little way out along each edge and back (the paper's spokes)."""

import math

from hslam_gvg.motion import go_to, turn_to
from hslam_gvg.reduced_graph import ReducedNode
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity

NEAR_M = 0.08
"""A step's end is reached within this: a probe looks, it does not measure."""
PATIENCE_NS = 6_000_000_000
"""A step of 0.6 m out takes some 3 s; one that takes twice as long is held up."""
LOOK_ROUND = math.radians(40.0)
"""To either side at a boundary point: two sonars of the Scout's ring, 22.5 degrees apart."""
ALIGNED = math.radians(5.0)
"""A look is turned to within this."""

Step = tuple[float, float] | float
"""A place to drive to (m, odom) or a direction to turn to (rad)."""


class Probe:
    """A short plan of places and directions, each given up when it takes too long or is blocked."""

    def __init__(self, steps: tuple[Step, ...]) -> None:
        """Take the plan."""
        self._steps = list(steps)
        self._began_ns: int | None = None

    @classmethod
    def along(cls, node: ReducedNode, base_in_odom: SE2, length_m: float) -> "Probe":
        """Plan a step along each edge of a meet point; at a boundary point, a look to both sides."""
        if node.degree == 1:
            heading = base_in_odom.theta
            return cls((wrap(heading + LOOK_ROUND), wrap(heading - LOOK_ROUND), heading))
        steps: list[Step] = []
        heading = base_in_odom.theta
        left = list(node.bearings)
        while left:
            # Least turning first; forwards or backwards is the same to the ring.
            following = min(left, key=lambda bearing: abs(math.remainder(bearing - heading, math.pi)))
            left.remove(following)
            heading = following
            tip = node.x + length_m * math.cos(following), node.y + length_m * math.sin(following)
            steps += [tip, (node.x, node.y)]
        return cls(tuple(steps))

    def skip(self) -> None:
        """Give up the step under way."""
        if self._steps:
            self._steps.pop(0)
        self._began_ns = None

    def step(
        self, base_in_odom: SE2, stamp_ns: int, speed: float, fastest_turn: float, blocked: bool
    ) -> Velocity | None:
        """Return the next command, None when the plan is done."""
        if self._began_ns is None:
            self._began_ns = stamp_ns
        while self._steps:
            step = self._steps[0]
            late = stamp_ns - self._began_ns > PATIENCE_NS
            if isinstance(step, float):
                if abs(wrap(step - base_in_odom.theta)) > ALIGNED and not late:
                    return turn_to(base_in_odom, step, fastest_turn)
            elif not (late or blocked) and math.hypot(step[0] - base_in_odom.x, step[1] - base_in_odom.y) > NEAR_M:
                return go_to(base_in_odom, *step, speed, fastest_turn)
            blocked = False
            self._steps.pop(0)
            self._began_ns = stamp_ns
        return None
