"""Which way of a new local graph goes on with the one that was followed, so that the robot does not change its mind."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from hslam_gvg.driving.handled import Handled
from hslam_gvg.local_graph.local_graph import LocalGraph, Way
from hslam_gvg.local_graph.polyline import arc_lengths, nearest
from hslam_types.se2 import SE2, Array, wrap

PASSED_LIMIT_M = 4.0
"""Nodes that are hidden are gone through for so long a way."""
COMPARED_M = 1.5
"""A way is compared with the old path so far ahead; farther on, the old look had guessed both."""
LEFT_M = 0.3
"""With less than this left of the old path, its last direction counts."""
OFF_SHARE = 0.3
"""Being off a way counts for so much a metre."""
JOINED_M, JOIN_TO_M = 0.3, 3.0
"""A path that is off the graph joins it where it comes this near to it, so far on at most."""
JOIN_UNLIKE = 0.6
"""A path joins a way only where it bends by less (1 - cos of the angle: 66 degrees)."""
LED_M = 0.5
"""Of a way shorter than this its direction is compared over what there is."""


class Match(NamedTuple):
    """A way onward and how ill it goes on with the old path (m)."""

    unlike_m: float
    way: Way


def ways_at(
    graph: LocalGraph, pose: SE2, handled: Handled, travel_m: float, reach_m: float = 0.5
) -> Iterator[tuple[float, Way]]:
    """Yield the ways onward from where the robot is, in both directions of each branch near by, and how far off (m).

    A branch is near within ``reach_m``, and where there is room for it somewhat farther off.
    """
    for branch, path in graph.paths():
        index, off_m = nearest(path, pose.x, pose.y)
        if off_m > max(reach_m, 0.7 * path[index, 2]):
            continue
        for forwards in (True, False):
            for way in graph.onwards(branch, index, forwards, PASSED_LIMIT_M, lambda hub: handled.hides(hub, travel_m)):
                yield off_m, way


def continued(
    graph: LocalGraph, old: Array, pose: SE2, handled: Handled, travel_m: float, limit_m: float
) -> Way | None:
    """Return the way most like the ``old`` path (k x 3); None where all are farther than ``limit_m`` from it."""
    matches = [
        Match(unlike_m(way.path, old, pose) + OFF_SHARE * off_m, way)
        for off_m, way in ways_at(graph, pose, handled, travel_m)
    ]
    best = min(matches, key=lambda match: match.unlike_m, default=None)
    if best is not None and best.unlike_m <= limit_m:
        return best.way
    return _joined(graph, old, pose, handled, travel_m)


def unlike_m(path: Array, old: Array, pose: SE2) -> float:
    """Return how far (m) a path from the robot lies from what is left of the old one, at equal ways along both."""
    index, _ = nearest(old, pose.x, pose.y)
    rest = old[index:] if index < len(old) - 1 else old[-2:]
    along, rest_along = arc_lengths(path), arc_lengths(rest)
    length = float(along[-1])
    left_m = min(COMPARED_M, float(rest_along[-1]))
    if left_m < LEFT_M:
        return _turned(path, along, old)
    at = np.arange(0.2, left_m + 1e-6, 0.1)
    at = at[at <= max(length, LEFT_M)]  # a way that ends at a node is compared as far as it goes
    dx = np.interp(at, along, path[:, 0]) - np.interp(at, rest_along, rest[:, 0])
    dy = np.interp(at, along, path[:, 1]) - np.interp(at, rest_along, rest[:, 1])
    weight = 1.0 + at
    apart = float((weight * np.hypot(dx, dy)).sum() / weight.sum())
    return apart + 0.25 if length < 0.25 else apart


def _turned(path: Array, along: Array, old: Array) -> float:
    begin = old[max(0, len(old) - 6)]
    direction = math.atan2(old[-1, 1] - begin[1], old[-1, 0] - begin[0])
    span = min(0.8, float(along[-1]))
    if span < 0.1:
        return 0.3
    px, py = np.interp(span, along, path[:, 0]) - path[0, 0], np.interp(span, along, path[:, 1]) - path[0, 1]
    return 0.35 * (1.0 - math.cos(wrap(math.atan2(py, px) - direction)))


def _joined(graph: LocalGraph, old: Array, pose: SE2, handled: Handled, travel_m: float) -> Way | None:
    """Return the way that the old path leads onto farther on, where the robot itself is off the graph."""
    index, _ = nearest(old, pose.x, pose.y)
    rest = old[index:]
    along = arc_lengths(rest)
    for k in range(0, len(rest), 2):
        if not 0.2 <= along[k] <= JOIN_TO_M:
            continue
        before = rest[max(0, k - 4)]
        heading = math.atan2(rest[k, 1] - before[1], rest[k, 0] - before[0])
        there = SE2(float(rest[k, 0]), float(rest[k, 1]), heading)
        near = [(off, way) for off, way in ways_at(graph, there, handled, travel_m) if off <= JOINED_M]
        turns = [(_bend(way.path, heading), i) for i, (_, way) in enumerate(near)]
        bend, best = min(turns, default=(math.inf, 0))
        if bend < JOIN_UNLIKE:
            way = near[best][1]
            return Way(np.vstack((rest[:k], way.path)), way.end)
    return None


def _bend(path: Array, heading: float) -> float:
    if len(path) <= 4:
        return 0.5
    return 1.0 - math.cos(wrap(math.atan2(path[4, 1] - path[0, 1], path[4, 0] - path[0, 0]) - heading))
