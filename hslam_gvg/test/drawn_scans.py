"""An exact planar scanner among drawn walls, for tests."""

import math

import numpy as np
from drawn_walls import Wall

from hslam_types.se2 import SE2
from hslam_types.sensing import RangeScan


def scan_of(
    walls: tuple[Wall, ...],
    base: SE2,
    beams: int = 360,
    view: float = math.tau,
    reach_m: float = 8.0,
    sensor_in_base: SE2 = SE2(),  # noqa: B008 (a NamedTuple, immutable)
    stamp_ns: int = 0,
) -> RangeScan:
    """Return the ranges to the nearest wall along each beam, +inf beyond reach."""
    sensor = base @ sensor_in_base
    step = view / beams if view > math.tau - 1e-6 else view / (beams - 1)
    first = -0.5 * view
    angles = sensor.theta + first + step * np.arange(beams)
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x1, y1, x2, y2 = np.array(walls, dtype=np.float64).T
    dx, dy = x2 - x1, y2 - y1
    cross = c * dy - s * dx
    with np.errstate(divide="ignore", invalid="ignore"):
        away = ((x1 - sensor.x) * dy - (y1 - sensor.y) * dx) / cross
        along = ((x1 - sensor.x) * s - (y1 - sensor.y) * c) / cross
    hit = (away > 0.0) & (along >= 0.0) & (along <= 1.0)
    ranges = np.where(hit, away, np.inf).min(axis=1)
    ranges[ranges > reach_m] = np.inf
    return RangeScan(stamp_ns, sensor_in_base, first, step, 0.12, reach_m, ranges)
