"""The closest points of the obstacles: distances d_i and where they are, for any query position.

A pure function of the local map and of the position, so that candidates for a meet point can be judged behind
the robot, where it has already seen all sides, and homed on before it drives back.
"""

import math
from typing import NamedTuple

import numpy as np

from hslam_gvg.arc import Flags
from hslam_types.se2 import Array

SMOOTHING_M = 0.04
"""A point counts as a local minimum if nothing beside it is nearer by more than this."""
BESIDE = math.radians(20.0)
"""What lies within this angle of a point is beside it; about a Polaroid sonar's whole cone."""


class ClosestPoint(NamedTuple):
    """The nearest point c_i of one obstacle, seen from the query position x."""

    distance_m: float
    """d_i = |x - c_i|."""
    bearing: float
    """Direction from x to c_i in odom (rad); the gradient of d_i points the other way."""

    @property
    def gradient(self) -> tuple[float, float]:
        """Return grad d_i = (x - c_i) / |x - c_i|, the unit vector away from the obstacle."""
        return -math.cos(self.bearing), -math.sin(self.bearing)


def closest_points(
    points: Array, x: float, y: float, reach_m: float, separation: float, most: int = 6
) -> list[ClosestPoint]:
    """Return the obstacles' closest points, nearest first.

    ``points`` (n x 2, m) and (x, y) are in one frame.  Each is a local minimum of distance over bearing and at
    least ``separation`` (rad) from every nearer one.
    """
    dx, dy = points[:, 0] - x, points[:, 1] - y
    squared = dx * dx + dy * dy
    near = (squared < reach_m * reach_m).nonzero()[0]
    if not len(near):
        return []
    distance = np.sqrt(squared[near])
    order = np.argsort(distance, kind="stable")
    distance = distance[order]
    bearing = np.arctan2(dy[near], dx[near])[order]
    found: list[ClosestPoint] = []
    free = np.ones(len(distance), dtype=bool)
    while len(found) < most and free.any():
        i = int(np.argmax(free))
        off = np.abs(np.remainder(bearing - bearing[i] + math.pi, 2.0 * math.pi) - math.pi)
        if not (off[:i] < BESIDE)[distance[:i] < distance[i] - SMOOTHING_M].any():
            found.append(ClosestPoint(float(distance[i]), float(bearing[i])))
            free &= off >= separation
        else:
            free[i] = False
    return found


def beside(
    points: Array, x: float, y: float, heading: float, reach_m: float
) -> tuple[ClosestPoint | None, ClosestPoint | None]:
    """Return the closest points on the left and on the right of a direction of travel (rad)."""
    dx, dy = points[:, 0] - x, points[:, 1] - y
    squared = dx * dx + dy * dy
    c, s = math.cos(heading), math.sin(heading)
    left = c * dy - s * dx
    # A cone ahead and one behind belong to neither side: what stands there is met, not passed.
    near = (np.abs(left) > 0.25 * np.sqrt(squared)) & (squared < reach_m * reach_m)
    on_left = left > 0.0
    return _nearest(dx, dy, squared, near & on_left), _nearest(dx, dy, squared, near & ~on_left)


def ahead(points: Array, x: float, y: float, heading: float, half_width_m: float, reach_m: float) -> float:
    """Return how far a straight strip ahead of a position is free of points (m), at most ``reach_m``."""
    dx, dy = points[:, 0] - x, points[:, 1] - y
    c, s = math.cos(heading), math.sin(heading)
    forward, left = c * dx + s * dy, c * dy - s * dx
    hit = forward[(np.abs(left) < half_width_m) & (forward > 0.0)]
    return min(float(hit.min()), reach_m) if len(hit) else reach_m


def _nearest(dx: Array, dy: Array, squared: Array, which: Flags) -> ClosestPoint | None:
    rows = which.nonzero()[0]
    if not len(rows):
        return None
    i = rows[squared[rows].argmin()]
    return ClosestPoint(math.sqrt(squared[i]), math.atan2(dy[i], dx[i]))
