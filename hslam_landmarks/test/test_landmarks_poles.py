"""Poles are told by their centre, whether many beams meet them or few; what is wide or leans on a wall is none."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scanned_walls import Wall, box, places, scan_of

from hslam_landmarks.config import ScanLandmarksConfig
from hslam_landmarks.scan_landmarks import look

CONFIG = ScanLandmarksConfig(range_max_m=12.0)
ROOM = box(-5.0, -5.0, 5.0, 5.0)


def pole(x: float, y: float, radius: float) -> list[Wall]:
    """Return a column of 24 sides."""
    at = [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in np.linspace(0.0, math.tau, 25).tolist()]
    return [(*a, *b) for a, b in pairwise(at)]


@pytest.mark.parametrize(("range_m", "radius"), [(1.0, 0.05), (1.5, 0.12), (3.0, 0.1), (3.5, 0.14)])
@pytest.mark.parametrize("bearing", [0.0, 1.0, math.pi - 1e-3, -2.0])
def test_a_pole_is_told_by_its_centre(range_m: float, radius: float, bearing: float) -> None:
    x, y = range_m * math.cos(bearing), range_m * math.sin(bearing)
    view = look(scan_of(ROOM + pole(x, y, radius)), CONFIG)
    (sighting,) = (s for s, place in zip(view.sightings, places(view), strict=True) if math.dist(place, (x, y)) < 0.3)
    assert abs(sighting.range_m - range_m) < 3.0 * sighting.range_std_m
    assert abs(math.remainder(sighting.bearing - bearing, math.tau)) < 3.0 * sighting.bearing_std
    assert sighting.range_std_m < 0.05


def test_a_pole_beside_a_wall_is_none() -> None:
    view = look(scan_of(ROOM + pole(4.95, 0.0, 0.1)), CONFIG)
    assert all(abs(s.bearing) > 0.1 for s in view.sightings)


def test_poles_can_be_left_out() -> None:
    none = ScanLandmarksConfig(range_max_m=12.0, pole_width_m=0.0)
    view = look(scan_of(ROOM + pole(2.0, 0.0, 0.1)), none)
    assert all(abs(s.bearing) > 0.1 for s in view.sightings)
