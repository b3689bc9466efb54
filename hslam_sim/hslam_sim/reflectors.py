"""Where two walls meet: concave corners, which send all sound back, and convex edges, which hardly answer.

Source: R. Kuc and M. W. Siegel, "Physically based simulation model for acoustic sensor robot navigation",
IEEE PAMI 9(6), 1987: planes, corners and edges are the reflectors of an indoor sonar.
"""

import math
from typing import NamedTuple

import numpy as np

from hslam_types.se2 import Array

CORNER_TURN = math.radians(60.0), math.radians(120.0)
"""Change of direction between the walls of a corner that works as a retroreflector (90 deg, loosely built)."""
EDGE_TURN = math.radians(-45.0)
"""Change of direction beyond which a convex vertex diffracts like an edge, not like a curved wall."""


class Reflectors(NamedTuple):
    """Point reflectors of a world: each n x 2 (m), in the world's order."""

    corners: Array
    edges: Array


def find_reflectors(segments: Array, shortest_wall_m: float) -> Reflectors:
    """Return the corners and edges of n x 4 directed segments (free space on the left).

    Both walls must be at least ``shortest_wall_m`` long: the steps of a rasterised wall are neither.
    """
    by_start = {(row[0], row[1]): i for i, row in enumerate(segments.tolist())}
    corners: list[tuple[float, float]] = []
    edges: list[tuple[float, float]] = []
    for x1, y1, x2, y2 in segments.tolist():
        following = by_start.get((x2, y2))
        if following is None:
            continue
        _, _, x3, y3 = segments[following].tolist()
        before, after = (x2 - x1, y2 - y1), (x3 - x2, y3 - y2)
        if min(math.hypot(*before), math.hypot(*after)) < shortest_wall_m:
            continue
        cross, dot = before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1]
        turn = math.atan2(cross, dot)
        if CORNER_TURN[0] <= turn <= CORNER_TURN[1]:
            corners.append((x2, y2))
        elif turn <= EDGE_TURN:
            edges.append((x2, y2))
    return Reflectors(np.array(corners).reshape(-1, 2), np.array(edges).reshape(-1, 2))
