"""What the GVG level announces and what it can be asked to do.

The map is built from events alone, never from goals: a replayed bag or a robot driven by a person
builds the same atlas.
"""

import math
from dataclasses import dataclass, replace
from enum import IntEnum

from hslam_types.se2 import SE2, wrap


class EventKind(IntEnum):
    """The moments of a traversal."""

    ACCESS = 1
    """The robot has reached the GVG inside an edge: a partial traversal begins."""
    DEPARTURE = 2
    """At a node, facing a branch, about to trace it."""
    ARRIVAL = 3
    """At a node whose kind, branches and clearance are now known (probed and verified)."""
    LOST = 4
    """The traversal under way is given up (no GVG in reach, the way was blocked)."""


class NodeKind(IntEnum):
    """The nodes of the reduced GVG."""

    MEET_POINT = 1
    BOUNDARY_POINT = 2


@dataclass(frozen=True, slots=True)
class NodeView:
    """A GVG node as seen on one visit, in the odom frame at the event's stamp."""

    kind: NodeKind
    x_in_odom: float
    y_in_odom: float
    clearance_m: float
    """Distance to the equidistant obstacles."""
    bearings_in_odom: tuple[float, ...]
    """Direction in which each edge leaves (rad), counter-clockwise."""

    @property
    def degree(self) -> int:
        """The number of edges that leave the node."""
        return len(self.bearings_in_odom)

    def reference_bearing(self, branch: int) -> float:
        """Return the direction (rad) that ties this view to a map: a branch's, or the first one's if unknown (-1)."""
        return self.bearings_in_odom[max(branch, 0)]

    def nearest_branch(self, bearing_in_odom: float) -> int:
        """Return the index of the edge that leaves nearest to a direction (rad)."""
        return min(range(self.degree), key=lambda i: abs(wrap(self.bearings_in_odom[i] - bearing_in_odom)))

    def moved(self, odom_in_other: SE2) -> "NodeView":
        """Return the view in another frame, given the pose of odom in it."""
        x, y = odom_in_other.apply(self.x_in_odom, self.y_in_odom)
        bearings = tuple(wrap(bearing + odom_in_other.theta) for bearing in self.bearings_in_odom)
        return replace(self, x_in_odom=x, y_in_odom=y, bearings_in_odom=bearings)


@dataclass(frozen=True, slots=True)
class GvgEvent:
    """One announcement; ``sequence`` counts all events of a run from 0 without gaps."""

    sequence: int
    stamp_ns: int
    kind: EventKind
    node: NodeView | None = None
    """Present at departure and arrival."""
    branch: int = -1
    """Index into the node's bearings: the edge left by (departure) or come along (arrival); -1 if unknown."""
    path_length_m: float = 0.0
    """Distance travelled since the last departure or access, by odometry."""

    def moved(self, odom_in_other: SE2) -> "GvgEvent":
        """Return the event with its node, if it has one, in another frame, given the pose of odom in it."""
        return self if self.node is None else replace(self, node=self.node.moved(odom_in_other))


class GoalKind(IntEnum):
    """What the GVG level can be asked to do."""

    ACCESS = 1
    """Reach the GVG from anywhere, then follow it to the first node, one way or the other."""
    TRACE = 2
    """From a node: turn to a branch, depart, trace the edge to its other end."""
    STRAIGHT = 3
    """Drive straight to a point nearer than any obstacle."""
    STOP = 4


@dataclass(frozen=True, slots=True)
class GvgGoal:
    """One goal; it ends with an event (arrival or lost), but for STOP and a STRAIGHT that gets there."""

    kind: GoalKind
    branch: int = -1
    """TRACE: index into the bearings of the node last arrived at."""
    x_in_odom: float = math.inf
    """STRAIGHT: the target point (m).  Not NaN where there is none: goals are compared, and NaN equals nothing."""
    y_in_odom: float = math.inf
    heading_in_odom: float | None = None
    """ACCESS: the way along the GVG nearer to this is followed (rad); None: the one nearer to the robot's heading."""
