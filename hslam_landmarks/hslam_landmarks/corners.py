"""Corners where two faces meet, and the ends of faces beside which the light goes on.

Where a face merely goes behind something nearer its last return is no landmark: it moves with the robot.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hslam_landmarks.config import ScanLandmarksConfig
from hslam_landmarks.faces import Face
from hslam_landmarks.outline import Outline
from hslam_types.se2 import Array

_BESIDE = 4
"""Returns beside a face's end that are looked at."""
_EDGE_ON = math.sin(math.radians(8.0))
"""A face seen at less than this angle does not tell where it would have gone on."""


class Point(NamedTuple):
    """A point landmark in the scanner's frame."""

    place: Array
    """Metres (2)."""
    covariance: Array
    """2 x 2, m^2."""


def corners(seen: Outline, found: list[Face], config: ScanLandmarksConfig) -> list[Point]:
    """Return the corners and ends of the faces ``found`` in an outline."""
    points: list[Point] = []
    taken: set[tuple[int, int]] = set()
    pairs = list(pairwise(found))
    if seen.circle and len(found) > 2:
        pairs.append((found[-1], found[0]))
    for before, after in pairs:
        corner = _corner(seen, before, after, config)
        if corner is not None:
            points.append(corner)
            taken |= {(before.first, 1), (after.first, -1)}
    for face in found:
        for side in (1, -1):
            if (face.first, side) not in taken:
                end = _end(seen, face, side, config)
                if end is not None:
                    points.append(end)
    return points


def crossing(normals: Array, distances: Array, variances: Array) -> Point:
    """Return where two lines ``normals @ p = distances`` cross; each is off by its own variance there."""
    inverse = np.linalg.inv(normals)
    return Point(inverse @ distances, (inverse * variances) @ inverse.T)


def _corner(seen: Outline, before: Face, after: Face, config: ScanLandmarksConfig) -> Point | None:
    """Return the corner of two neighbouring faces, None if they are parallel or do not touch."""
    (a, b), (c, d) = before.normal.tolist(), after.normal.tolist()
    if abs(a * d - b * c) < math.sin(config.least_turn):
        return None
    normals = np.array([before.normal, after.normal])
    distances = np.array([before.distance_m, after.distance_m])
    place = np.linalg.solve(normals, distances)
    for face, last in ((before, before.last), (after, after.first)):
        off = place - seen.points[last]
        range_m = float(seen.range_m[last])
        slant = max(float(seen.points[last] @ face.normal) / range_m, _EDGE_ON)
        reach = 3.0 * range_m * seen.step / slant + 4.0 * config.range_std_m
        if math.hypot(*off.tolist()) > reach:
            return None
    return crossing(normals, distances, np.array([before.variance_at(place), after.variance_at(place)]))


def _end(seen: Outline, face: Face, side: int, config: ScanLandmarksConfig) -> Point | None:
    """Return the end of a face on a side if the light goes on beside it, None where something nearer hides the rest."""
    last = face.last if side > 0 else face.first
    beside = seen.beside(last, side, _BESIDE)
    if len(beside) < 2 or beside[0][1] > 2 or beside[1][1] > 4:
        return None
    behind = []
    for position, away in beside:
        bearing = seen.bearing[last] + side * away * seen.step
        slant = float(face.normal[0] * math.cos(bearing) + face.normal[1] * math.sin(bearing))
        if slant < _EDGE_ON:
            return None
        behind.append(float(seen.range_m[position]) - face.distance_m / slant)
    if min(behind[:2]) < -3.0 * config.range_std_m or max(behind) < config.least_depth_m:
        return None
    deep = next(k for k, depth in enumerate(behind) if depth >= config.least_depth_m)
    if min(behind[: deep + 1]) < 0.0 or min(behind[deep:]) < config.least_depth_m or deep > 2:
        return None
    gap = beside[0][1] * seen.step
    bearing = seen.bearing[last] + 0.5 * side * gap
    ray = np.array([-math.sin(bearing), math.cos(bearing)])
    normals, distances = np.array([face.normal, ray]), np.array([face.distance_m, 0.0])
    place = np.linalg.solve(normals, distances)
    # Anywhere between the last beam that met the face and the first that did not.
    along = float(place @ place) * gap * gap / 12.0
    return crossing(normals, distances, np.array([face.variance_at(place), along]))
