"""The edge under way: the one owner of what was departed from, of the trail since, and of every announcement."""

import math
from dataclasses import dataclass

import numpy as np

from hslam_types.gvg_events import EventKind, GvgEvent, NodeView
from hslam_types.se2 import Array

TRAIL_STEP_M = 0.08
"""Spacing of the trail, about that of the local graph's paths."""
TRAIL_CLEARANCE_M = 0.3
"""What a trail is given for its clearance, where a path is wanted: nobody measured it."""


@dataclass(frozen=True, slots=True)
class Leg:
    """Where a traversal began: at a node by one of its branches, or somewhere on the GVG."""

    node: NodeView | None = None
    branch: int = -1
    paths: tuple[Array, ...] = ()
    """The path of every branch of the node, k x 3."""


class Traversal:
    """Announces departures and arrivals, and ends what it began: whatever ends a traversal is announced."""

    def __init__(self) -> None:
        """Begin with none under way."""
        self.leg: Leg | None = None
        """None while no traversal is under way."""
        self.length_m = 0.0
        self.events: list[GvgEvent] = []
        """What this step has to announce."""
        self._sequence = 0
        self._stamp_ns = 0
        self._trail: list[tuple[float, float, float]] = []
        """Places along the edge (m, odom), with the length there."""

    def begin_step(self, stamp_ns: int) -> None:
        """Begin a step with nothing to announce."""
        self.events, self._stamp_ns = [], stamp_ns

    def access(self) -> None:
        """Announce that the GVG is reached inside an edge."""
        self._begin(Leg())
        self._announce(EventKind.ACCESS)

    def depart(self, leg: Leg) -> None:
        """Announce a departure from a node."""
        self._begin(leg)
        self._announce(EventKind.DEPARTURE, leg.node, leg.branch)

    def arrive(self, node: NodeView, branch: int) -> None:
        """Announce the arrival at a node by one of its branches (-1 where that is not known)."""
        self._announce(EventKind.ARRIVAL, node, branch, self.length_m)
        self.leg = None

    def give_up(self) -> None:
        """End the traversal under way, if there is one, without an arrival."""
        if self.leg is not None:
            self.lose()

    def lose(self) -> None:
        """Announce a loss, of a traversal or of the goal to begin one."""
        self._announce(EventKind.LOST)
        self.leg = None

    def advance(self, x: float, y: float, way_m: float) -> None:
        """Take the robot's place; ``way_m`` is what of its way leads along the edge: only that is on the trail."""
        if self.leg is None:
            return
        self.length_m += way_m
        along = way_m > 0.0
        if along and (not self._trail or math.hypot(self._trail[-1][0] - x, self._trail[-1][1] - y) > TRAIL_STEP_M):
            self._trail.append((x, y, self.length_m))

    def rewind(self, x: float, y: float, reach_m: float) -> None:
        """Go back to the place nearest to (x, y) on the last ``reach_m`` of the trail: what came after was too far."""
        steps = round(reach_m / TRAIL_STEP_M)
        recent = range(max(0, len(self._trail) - steps), len(self._trail))
        nearest = min(recent, key=lambda i: math.hypot(self._trail[i][0] - x, self._trail[i][1] - y), default=None)
        if nearest is not None:
            self.cut(len(self._trail) - 1 - nearest)

    def cut(self, places: int) -> None:
        """Take so many places off the end of the trail, at most all but the first, and the way between them."""
        del self._trail[max(1, len(self._trail) - places) :]
        self.length_m = self._trail[-1][2]

    def back(self, reach_m: float = math.inf) -> Array:
        """Return the trail as a path backwards from the robot's place, k x 3 (m, odom), at most about so long."""
        kept = self._trail if math.isinf(reach_m) else self._trail[-max(1, round(reach_m / TRAIL_STEP_M)) :]
        return np.array([(x, y, TRAIL_CLEARANCE_M) for x, y, _ in reversed(kept)]).reshape(-1, 3)

    def _begin(self, leg: Leg) -> None:
        self.give_up()
        self.leg, self.length_m, self._trail = leg, 0.0, []

    def _announce(self, kind: EventKind, node: NodeView | None = None, branch: int = -1, length_m: float = 0.0) -> None:
        self.events.append(GvgEvent(self._sequence, self._stamp_ns, kind, node, branch, length_m))
        self._sequence += 1
