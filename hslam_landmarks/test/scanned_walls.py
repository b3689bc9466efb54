"""A planar scanner among drawn walls, for tests, and what its looks say where landmarks are."""

import math
from collections.abc import Sequence

import numpy as np

from hslam_types.se2 import SE2, Array
from hslam_types.sensing import LandmarkView, RangeScan

Wall = tuple[float, float, float, float]
"""x1, y1, x2, y2 (m)."""


def scan_of(
    walls: Sequence[Wall],
    base: SE2 = SE2(),  # noqa: B008 (a NamedTuple, immutable)
    *,
    beams: int = 360,
    view: float = math.tau,
    first: float | None = None,
    sensor_in_base: SE2 = SE2(),  # noqa: B008 (a NamedTuple, immutable)
    noise: tuple[float, np.random.Generator] | None = None,
) -> RangeScan:
    """Return the ranges to the nearest wall along each beam, +inf beyond 12 m; ``noise``: deviation (m) and draws."""
    sensor = base @ sensor_in_base
    step = view / beams if view > math.tau - 1e-6 else view / (beams - 1)
    begin = -0.5 * view if first is None else first
    angles = sensor.theta + begin + step * np.arange(beams)
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x1, y1, x2, y2 = np.array(walls, dtype=np.float64).T
    dx, dy = x2 - x1, y2 - y1
    cross = c * dy - s * dx
    with np.errstate(divide="ignore", invalid="ignore"):
        away = ((x1 - sensor.x) * dy - (y1 - sensor.y) * dx) / cross
        along = ((x1 - sensor.x) * s - (y1 - sensor.y) * c) / cross
    ranges = np.where((away > 0.0) & (along >= 0.0) & (along <= 1.0), away, np.inf).min(axis=1)
    if noise is not None:
        ranges = ranges + noise[0] * noise[1].standard_normal(beams)
    ranges[ranges > 12.0] = np.inf
    return RangeScan(0, sensor_in_base, begin, step, 0.1, 12.0, ranges)


def box(x1: float, y1: float, x2: float, y2: float) -> list[Wall]:
    """Return the four walls of a box."""
    return [(x1, y1, x2, y1), (x2, y1, x2, y2), (x2, y2, x1, y2), (x1, y2, x1, y1)]


def places(view: LandmarkView, base: SE2 = SE2()) -> Array:  # noqa: B008 (a NamedTuple, immutable)
    """Return where the sightings of a look lie, n x 2 (m), in the frame of the robot's pose."""
    return base.apply_all(
        np.array([(s.range_m * math.cos(s.bearing), s.range_m * math.sin(s.bearing)) for s in view.sightings]).reshape(
            -1, 2
        )
    )


def sorted_rows(points: Array) -> Array:
    """Return points in order of x, then y, to the nearest decimetre."""
    near = np.round(points, 1)
    return points[np.lexsort((near[:, 1], near[:, 0]))]
