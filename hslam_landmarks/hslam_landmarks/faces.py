"""Straight faces of walls in an outline: split, merge, fit (Nguyen et al., "A comparison of line extraction", 2007)."""

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from hslam_landmarks.config import ScanLandmarksConfig
from hslam_landmarks.outline import Outline
from hslam_types.se2 import Array

_OUTLIER = 3.0
"""Deviations beyond which a return at a face's end is no longer of it."""
_ROUGH_M = 0.001
"""Deviation of a wall's surface at least."""
_NOISE = 4.0
"""Deviations that the farthest return of a face, and those at its ends, are off together."""
_VAGUEST = 0.1
"""Deviation of a face's direction (rad) beyond which it is too short for its noise."""


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A line fitted to neighbouring returns: ``normal . p = distance_m``, the normal pointing away from the scanner."""

    first: int
    last: int
    """Positions of its outermost returns in the outline."""
    normal: Array
    distance_m: float
    middle: Array
    """Mean of the returns (2, m)."""
    returns: int
    spread: float
    """Sum of the squared distances along the face from the middle (m^2)."""
    variance: float
    """Of one return across the face (m^2)."""

    def variance_at(self, point: Array) -> float:
        """Return the variance (m^2) of the line across itself at a point on it: of its place and of its direction."""
        off = point - self.middle
        along = self.normal[0] * off[1] - self.normal[1] * off[0]
        return self.variance * (1.0 / self.returns + float(along * along) / self.spread)


def faces(seen: Outline, config: ScanLandmarksConfig, apart: Collection[int] = ()) -> list[Face]:
    """Return the faces of an outline in its order; the stretches that begin ``apart`` have none."""
    found: list[Face] = []
    ends = [*seen.breaks[1:].tolist(), len(seen.beam)]
    for first, end in zip(seen.breaks.tolist(), ends, strict=True):
        if first in apart:
            continue
        for a, b in _merged(seen.points, _split(seen.points, first, end - 1, config), config):
            face = _fitted(seen, (a, b), (int(a > first), int(b < end - 1)), config)
            if face is not None:
                found.append(face)
    return found


def split_m(config: ScanLandmarksConfig) -> float:
    """Return how far (m) a return may lie from a face before that is divided: noise alone does not divide it."""
    return max(config.split_m, _NOISE * config.range_std_m)


def _split(points: Array, first: int, last: int, config: ScanLandmarksConfig) -> list[tuple[int, int]]:
    """Divide a stretch at the return farthest from the line through its ends until none is far; short ones fall out."""
    pieces, stack = [], [(first, last)]
    farthest = split_m(config)
    while stack:
        a, b = stack.pop()
        if b - a + 1 < config.least_returns:
            continue
        chord = points[b] - points[a]
        length = math.hypot(*chord.tolist())
        off = points[a : b + 1] - points[a]
        far = np.abs(chord[0] * off[:, 1] - chord[1] * off[:, 0]) / length if length > 1e-6 else np.hypot(*off.T)
        k = int(np.argmax(far))
        if far[k] > farthest and 0 < k < b - a:
            stack += [(a + k, b), (a, a + k)]
        else:
            pieces.append((a, b))
    return pieces


def _merged(points: Array, pieces: list[tuple[int, int]], config: ScanLandmarksConfig) -> list[tuple[int, int]]:
    """Join neighbouring pieces that one line fits as well: a split goes through a stray return at times."""
    joined: list[tuple[int, int]] = []
    for a, b in pieces:
        if joined and a - joined[-1][1] <= 2:
            before = joined[-1][0]
            middle, normal, _, _ = _line(points[before : b + 1])
            if np.abs((points[before : b + 1] - middle) @ normal).max() < 0.7 * split_m(config):
                joined[-1] = (before, b)
                continue
        joined.append((a, b))
    return joined


def _fitted(seen: Outline, piece: tuple[int, int], split: tuple[int, int], config: ScanLandmarksConfig) -> Face | None:
    """Return the face through a piece's returns but those at its ends that do not fit; None if it is too small.

    The return at a ``split`` (1 at a split end) may be of either face: it tells how far this one goes, not how it lies.
    """
    a, b = piece[0] + split[0], piece[1] - split[1]
    while b - a + 1 >= config.least_returns:
        points = seen.points[a : b + 1]
        middle, normal, spread, across = _line(points)
        slant = points @ normal / seen.range_m[a : b + 1]
        count = len(points)
        own = float(np.mean(slant * slant)) * config.range_std_m**2
        limit = _OUTLIER * math.sqrt(max(own, _ROUGH_M**2))
        off = np.abs((seen.points[piece[0] : piece[1] + 1] - middle) @ normal)
        stray = int(off[a - piece[0]] > limit), int(off[b - piece[0]] > limit)
        if any(stray):
            a, b = a + stray[0], b - stray[1]
            continue
        variance = max(own, across / (count - 2), 1e-8)
        crooked = math.sqrt(across / count) > 0.5 * split_m(config)
        if crooked or math.sqrt(variance / spread) > _VAGUEST or _length(points) < config.least_length_m:
            return None
        a -= int(a > piece[0] and off[a - 1 - piece[0]] <= limit)
        b += int(b < piece[1] and off[b + 1 - piece[0]] <= limit)
        return Face(a, b, normal, float(middle @ normal), middle, count, spread, variance)
    return None


def _length(points: Array) -> float:
    return math.hypot(*(points[-1] - points[0]).tolist())


def _line(points: Array) -> tuple[Array, Array, float, float]:
    """Return middle, unit normal (away from the scanner) and the squared spread along and across the best line."""
    middle = points.mean(axis=0)
    off = points - middle
    xx, xy, yy = float(off[:, 0] @ off[:, 0]), float(off[:, 0] @ off[:, 1]), float(off[:, 1] @ off[:, 1])
    direction = 0.5 * math.atan2(2.0 * xy, xx - yy)
    normal = np.array([-math.sin(direction), math.cos(direction)])
    if normal @ middle < 0.0:
        normal = -normal
    half = math.hypot(0.5 * (xx - yy), xy)
    return middle, normal, max(0.5 * (xx + yy) + half, 1e-12), max(0.5 * (xx + yy) - half, 0.0)
