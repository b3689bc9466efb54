"""Walls as points, for tests: junctions of corridors 2.4 m wide round the origin, and an ideal sonar."""

import functools
import math

import numpy as np

from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SCOUT_RING

HALF = 1.2
Wall = tuple[float, float, float, float]

T_JUNCTION: tuple[Wall, ...] = (
    (-8, HALF, 8, HALF),
    (-8, -HALF, -HALF, -HALF),
    (HALF, -HALF, 8, -HALF),
    (-HALF, -HALF, -HALF, -8),
    (HALF, -HALF, HALF, -8),
)
CROSSING: tuple[Wall, ...] = tuple(
    wall
    for a in (-1.0, 1.0)
    for b in (-1.0, 1.0)
    for wall in ((a * HALF, b * HALF, a * 8, b * HALF), (a * HALF, b * HALF, a * HALF, b * 8))
)
L_CORNER: tuple[Wall, ...] = (
    (-8, HALF, HALF, HALF),
    (HALF, HALF, HALF, -8),
    (-8, -HALF, -HALF, -HALF),
    (-HALF, -HALF, -HALF, -8),
)
DEAD_END: tuple[Wall, ...] = ((-8, HALF, HALF, HALF), (HALF, HALF, HALF, -HALF), (HALF, -HALF, -8, -HALF))
ALCOVE: tuple[Wall, ...] = (
    (-8, HALF, -1, HALF),
    (-1, HALF, -1, 2),
    (-1, 2, 1, 2),
    (1, 2, 1, HALF),
    (1, HALF, 8, HALF),
    (-8, -HALF, 8, -HALF),
)


def points_of(walls: tuple[Wall, ...], noise_m: float = 0.0, seed: int = 0, step_m: float = 0.15) -> Array:
    """Return points along walls (n x 2, m) with Gaussian noise."""
    stretches = []
    for x1, y1, x2, y2 in walls:
        share = np.linspace(0.0, 1.0, max(2, round(math.hypot(x2 - x1, y2 - y1) / step_m) + 1))[:, None]
        stretches.append(np.array([x1, y1]) + share * np.array([x2 - x1, y2 - y1]))
    points = np.concatenate(stretches)
    noisy: Array = points + np.random.default_rng(seed).normal(0.0, noise_m, points.shape)
    return noisy


def ideal_range(walls: tuple[Wall, ...], base: SE2, sensor: int) -> float:
    """Return the distance (m) from a sonar of the Scout to the nearest wall point in its cone, +inf for none."""
    axis = base.theta + SCOUT_RING.bearings[sensor]
    mount = SCOUT_RING.mount_radius_m
    x, y = base.x + mount * math.cos(axis), base.y + mount * math.sin(axis)
    dense = _dense(walls)
    dx, dy = dense[:, 0] - x, dense[:, 1] - y
    distance = np.hypot(dx, dy)
    heard = dx * math.cos(axis) + dy * math.sin(axis) > math.cos(SCOUT_RING.cone_half_angle) * distance
    return float(distance[heard].min()) if heard.any() else math.inf


@functools.cache
def _dense(walls: tuple[Wall, ...]) -> Array:
    return points_of(walls, step_m=0.02)
