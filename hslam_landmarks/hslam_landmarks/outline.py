"""The returns of one scan in order of bearing: what the scanner saw as one line of points."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hslam_types.se2 import Array
from hslam_types.sensing import RangeScan

Indices = npt.NDArray[np.int64]

_FLATTEST = math.radians(10.0)
"""Two returns belong to one surface unless that would be seen at less than this angle."""
_MOST_SILENT = 2
"""Beams without an answer that a surface may run through."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Returns in the scanner's frame, counter-clockwise; a closed one begins where the surroundings are most broken."""

    beam: Indices
    """Number of each return's beam, ascending; past the last beam of a full circle it counts on."""
    range_m: Array
    bearing: Array
    points: Array
    """Metres, n x 2."""
    step: float
    """Angle (rad) from one beam to the next."""
    circle: int
    """Beams of a full circle; 0 for a scan with two ends."""
    breaks: Indices
    """Positions of the returns that begin a new stretch, the first always."""

    def beside(self, position: int, side: int, count: int) -> list[tuple[int, int]]:
        """Return up to ``count`` next returns on a ``side`` (+1, -1): positions, and how many beams away they are."""
        found = []
        size = len(self.beam)
        for k in range(1, count + 1):
            at = position + side * k
            turns, wrapped = divmod(at, size)
            if (turns and not self.circle) or k >= size:
                break
            away = side * int(self.beam[wrapped] - self.beam[position]) + side * turns * self.circle
            found.append((wrapped, away))
        return found


def outline(scan: RangeScan, range_std_m: float) -> Outline | None:
    """Return what a scan saw, None if fewer than three beams were answered.

    Stretches are divided where two neighbours lie farther apart than on any surface that is not seen edge on (Borges
    and Aldon, "Line extraction in 2D range images for mobile robotics", 2004).
    """
    ranges = scan.ranges
    with np.errstate(invalid="ignore"):
        beam = np.flatnonzero((ranges >= scan.range_min_m) & (ranges <= scan.range_max_m))
    if len(beam) < 3:
        return None
    beams = len(ranges)
    closed = abs(scan.bearing_step * beams - math.tau) < 0.5 * scan.bearing_step
    circle = beams if closed else 0
    range_m: Array = ranges[beam]
    bearing: Array = scan.first_bearing + scan.bearing_step * beam.astype(np.float64)
    points = np.column_stack((range_m * np.cos(bearing), range_m * np.sin(bearing)))
    broken = _broken(beam, range_m, points, scan.bearing_step, circle, range_std_m)
    if closed:
        # Where nothing is broken, in the midst of the nearest wall: both its halves are long and seen well.
        first = int(np.argmax(broken) if broken.max() > 1.0 else np.argmin(range_m))
        beam = np.concatenate((beam[first:], beam[:first] + beams))
        range_m, bearing, points, broken = (np.roll(a, -first, axis=0) for a in (range_m, bearing, points, broken))
    broken[0] = np.inf
    return Outline(beam, range_m, bearing, points, scan.bearing_step, circle, np.flatnonzero(broken > 1.0))


def _broken(beam: Indices, range_m: Array, points: Array, step: float, circle: int, range_std_m: float) -> Array:
    """Return how many times farther each return lies from the one before it than one surface would have it."""
    apart = np.hypot(*(points - np.roll(points, 1, axis=0)).T)
    away = beam - np.roll(beam, 1)
    away[0] += circle
    nearer = np.minimum(range_m, np.roll(range_m, 1))
    ratio: Array = apart / (nearer * away * step / math.sin(_FLATTEST) + 3.0 * range_std_m)
    ratio[away > 1 + _MOST_SILENT] = np.inf
    return ratio
