"""The way off the graph: when a point beside the way is to be made for, and whether it has been reached."""

import math
from dataclasses import dataclass

_THERE_M = 0.1
"""So near to the point nothing is gained by waiting."""
_PAST_M = 0.03
"""Farther from the point than it once was by this, the robot has passed the place nearest to it."""
_BEYOND_CLEARANCE_M = 0.1
"""A clearance is read from a map with this much error; the straight drive stops at what is in its way all the same."""
WATCHED_M = 5.0
"""Within this distance of the point the robot's place is made sure of by the edge's map."""


@dataclass(slots=True)
class Approach:
    """Watches the distance to a point while the robot passes it."""

    nearest_m: float = math.inf

    def is_time(self, distance_m: float, room_m: float) -> bool:
        """Whether to leave the graph now: the point is nearer than any obstacle, and will not come nearer."""
        within = distance_m <= room_m + _BEYOND_CLEARANCE_M
        self.nearest_m = min(self.nearest_m, distance_m)
        if distance_m <= _THERE_M:
            return True
        return within and distance_m > self.nearest_m + _PAST_M


def reached(distance_m: float, tolerance_m: float) -> bool:
    """Whether a straight drive that has ended has ended at its point."""
    return distance_m <= tolerance_m
