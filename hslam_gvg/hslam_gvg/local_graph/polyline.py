"""Paths as k x 3 arrays of x, y and clearance (m, odom): their length, their points, how unlike two of them are."""

import math

import numpy as np

from hslam_types.se2 import Array, wrap

SPACING_M = 0.08
"""Between the points of a resampled path."""
COMPARED_FROM_M, COMPARED_EVERY_M = 0.2, 0.1


def straight_on(x: float, y: float, direction: float, way_m: float, clearance_m: float) -> Array:
    """Return the path from a place straight on in a direction (rad)."""
    along = np.arange(0.0, way_m, SPACING_M)
    ahead = x + along * math.cos(direction), y + along * math.sin(direction)
    return np.column_stack((*ahead, np.full(len(along), clearance_m)))


def arc_lengths(path: Array) -> Array:
    """Return the way (m) from the path's beginning to each of its points."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(path[:, 0]), np.diff(path[:, 1])))])


def length_m(path: Array) -> float:
    """Return the length of a path (m)."""
    return float(arc_lengths(path)[-1])


def resampled(path: Array) -> Array:
    """Return the path by points at equal spacing, its ends kept."""
    along = arc_lengths(path)
    at = np.linspace(0.0, along[-1], max(2, math.ceil(along[-1] / SPACING_M) + 1))
    return np.column_stack([np.interp(at, along, path[:, k]) for k in range(3)])


def nearest(path: Array, x: float, y: float) -> tuple[int, float]:
    """Return the index of the path's point nearest to a place, and how far (m) it is."""
    distance = np.hypot(path[:, 0] - x, path[:, 1] - y)
    index = int(np.argmin(distance))
    return index, float(distance[index])


def chord_bearing(path: Array, chord_m: float) -> float:
    """Return the direction (rad) from a path's beginning to where it leaves a circle about it, else to its end."""
    x, y = path[0, 0], path[0, 1]
    distance = np.hypot(path[:, 0] - x, path[:, 1] - y)
    outside = np.flatnonzero(distance >= chord_m)
    if len(outside) == 0 or outside[0] == 0:
        return math.atan2(path[-1, 1] - y, path[-1, 0] - x)
    k = outside[0]
    share = (chord_m - distance[k - 1]) / (distance[k] - distance[k - 1])
    px, py = path[k - 1, :2] + share * (path[k, :2] - path[k - 1, :2])
    return math.atan2(py - y, px - x)


def apart_m(path: Array, other: Array, span_m: float) -> float:
    """Return the mean distance (m) between two paths from their beginnings, at equal ways along them, far ones first.

    They are compared over ``span_m`` or the shorter one's length; +inf where that leaves nothing to compare.
    """
    along, other_along = arc_lengths(path), arc_lengths(other)
    span = min(span_m, float(along[-1]), float(other_along[-1]))
    at = np.arange(COMPARED_FROM_M, span + 1e-6, COMPARED_EVERY_M)
    if len(at) == 0:
        return math.inf
    dx = np.interp(at, along, path[:, 0]) - np.interp(at, other_along, other[:, 0])
    dy = np.interp(at, along, path[:, 1]) - np.interp(at, other_along, other[:, 1])
    return float((at * np.hypot(dx, dy)).sum() / at.sum())


def turned_from(path: Array, direction: float, over_m: float) -> float:
    """Return by what angle (rad, 0 to pi) the beginning of a path turns from a direction (rad)."""
    along = arc_lengths(path)
    at = min(over_m, float(along[-1]))
    px, py = np.interp(at, along, path[:, 0]) - path[0, 0], np.interp(at, along, path[:, 1]) - path[0, 1]
    return abs(wrap(math.atan2(py, px) - direction))
