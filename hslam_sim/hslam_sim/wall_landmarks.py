"""Unlabelled landmarks on the walls: the paper's small boxes, put down by a seed.

The spacing is irregular (a least gap plus an exponential remainder), so that no two stretches of wall
carry the same pattern.
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely

from hslam_types.config import Configuration, parameter
from hslam_types.se2 import Array


@dataclass(frozen=True)
class WallLandmarks(Configuration):
    """How densely the walls carry landmarks."""

    per_metre: float = parameter(
        1.0, "mean number of boxes on a metre of wall (paper, section IV: 'throughout each hallway')", low=0.0, high=1.5
    )
    least_gap_m: float = parameter(0.6, "no two boxes are nearer than this", low=0.05, high=10.0, unit="m")
    standoff_m: float = parameter(
        0.03, "how far the visible foot of a box stands off its wall", low=0.001, high=0.2, unit="m"
    )


def place(free_space: shapely.Polygon, config: WallLandmarks, rng: np.random.Generator) -> Array:
    """Return landmark positions (n x 2, m, in map) just in front of the walls of ``free_space``."""
    if config.per_metre == 0.0:
        return np.empty((0, 2))
    remainder = max(1.0 / config.per_metre - config.least_gap_m, 0.05)
    facing_in = shapely.geometry.polygon.orient(free_space, 1.0)
    candidates = [
        _along(np.asarray(ring.coords), config, remainder, rng) for ring in (facing_in.exterior, *facing_in.interiors)
    ]
    points = np.concatenate(candidates)
    inside = points[shapely.contains_xy(free_space, points[:, 0], points[:, 1])]
    return _thinned(inside, config.least_gap_m)


def _along(ring: Array, config: WallLandmarks, remainder: float, rng: np.random.Generator) -> Array:
    """Return points at random gaps along one closed ring (free space on its left), n x 2."""
    steps = np.diff(ring, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    ends = np.cumsum(lengths)
    if ends[-1] <= 0.0:
        return np.empty((0, 2))
    count = int(ends[-1] / config.least_gap_m) + 1
    gaps = config.least_gap_m + rng.exponential(remainder, count)
    first = rng.uniform(0.0, config.least_gap_m + remainder)
    at = first + np.concatenate([[0.0], np.cumsum(gaps)])
    at = at[at < ends[-1]]
    which = np.minimum(np.searchsorted(ends, at, side="right"), len(ends) - 1)
    along = steps[which] / lengths[which, None]
    inward = np.column_stack([-along[:, 1], along[:, 0]])
    back = (at - (ends[which] - lengths[which]))[:, None]
    points: Array = ring[which] + along * back + inward * config.standoff_m
    return points


def _thinned(points: Array, least_gap: float) -> Array:
    """Drop every point nearer than ``least_gap`` (m) to one kept before it; a corner brings two walls together."""
    kept: list[tuple[float, float]] = []
    cells: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for x, y in points.tolist():
        column, row = math.floor(x / least_gap), math.floor(y / least_gap)
        near = (
            other
            for i in (column - 1, column, column + 1)
            for j in (row - 1, row, row + 1)
            for other in cells.get((i, j), ())
        )
        if all(math.hypot(x - u, y - v) >= least_gap for u, v in near):
            kept.append((x, y))
            cells.setdefault((column, row), []).append((x, y))
    return np.array(kept).reshape(-1, 2)
