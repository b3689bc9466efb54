"""Things that stand free: narrow, with the surroundings farther away on both sides."""

import math

import numpy as np

from hslam_landmarks.config import ScanLandmarksConfig
from hslam_landmarks.corners import Point
from hslam_landmarks.outline import Outline

_LEAST_RETURNS = 3
_ROUND = math.pi / 4.0
"""The mean depth of a disc's front before its centre, by its radius."""


def poles(seen: Outline, config: ScanLandmarksConfig) -> dict[int, Point]:
    """Return the centres of the poles in an outline, taken for round, by where each one begins."""
    found: dict[int, Point] = {}
    if config.pole_width_m == 0.0:
        return found
    ends = [*seen.breaks[1:].tolist(), len(seen.beam)]
    for first, end in zip(seen.breaks.tolist(), ends, strict=True):
        count = end - first
        angle = float(seen.beam[end - 1] - seen.beam[first] + 1) * seen.step
        nearest = float(seen.range_m[first:end].min())
        if count < _LEAST_RETURNS or nearest * angle > config.pole_width_m or not _free(seen, first, end - 1, config):
            continue
        radius = 0.5 * nearest * angle
        range_m = float(seen.range_m[first:end].mean()) + _ROUND * radius
        # Each edge lies anywhere between two beams; the shape is a guess.
        edge = range_m * seen.step / math.sqrt(12.0)
        across = edge * edge / 2.0
        along = config.range_std_m**2 / count + _ROUND**2 * edge * edge / 2.0 + (0.2 * radius) ** 2
        bearing = 0.5 * float(seen.bearing[first] + seen.bearing[first] + angle - seen.step)
        c, s = math.cos(bearing), math.sin(bearing)
        turned = np.array([[c, -s], [s, c]])
        found[first] = Point(range_m * turned[:, 0], (turned * (along, across)) @ turned.T)
    return found


def _free(seen: Outline, first: int, last: int, config: ScanLandmarksConfig) -> bool:
    """Tell whether the light goes on beside a stretch, on both its sides."""
    for position, side in ((first, -1), (last, 1)):
        beside = seen.beside(position, side, 2)
        if len(beside) < 2 or beside[1][1] > 3:
            return False
        if any(seen.range_m[other] - seen.range_m[position] < config.least_depth_m for other, _ in beside):
            return False
    return True
