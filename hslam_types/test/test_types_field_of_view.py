"""What a sensor's field of view shows: against a sector drawn by hand, wherever it opens and the sensor sits."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.se2 import wrap
from hslam_types.sensing import FieldOfView

ANGLES = st.floats(-math.pi, math.pi)
OFFSETS = st.floats(-1.0, 1.0)
RANGE_M = 5.0


@given(OFFSETS, OFFSETS, ANGLES, st.floats(0.1, 6.2), ANGLES, st.floats(0.01, 8.0), st.floats(0.0, 0.5))
def test_a_place_is_shown_inside_the_sector_alone(
    x: float, y: float, first: float, width: float, direction: float, distance: float, margin: float
) -> None:
    field = FieldOfView(x, y, first, wrap(first + width), range_min_m=0.3)
    place = (x + distance * math.cos(direction), y + distance * math.sin(direction))
    seen_from_base = np.array([[math.hypot(*place), math.atan2(place[1], place[0])]])
    past_the_edge = (direction - first) % math.tau
    edges = (past_the_edge - margin, width - margin - past_the_edge, distance - 0.3, RANGE_M - distance)
    shown = field.shows(seen_from_base, RANGE_M, np.array([margin]))
    if min(map(abs, edges)) > 1e-6:
        assert bool(shown[0]) is all(edge > 0.0 for edge in edges)


@given(ANGLES, ANGLES, st.floats(0.0, 8.0))
def test_all_round_it_is_the_range_alone(same: float, direction: float, distance: float) -> None:
    for field in (FieldOfView(), FieldOfView(bearing_from=same, bearing_to=same)):
        shown = field.shows(np.array([[distance, direction]]), RANGE_M, np.array([3.0]))
        assert bool(shown[0]) is (distance < RANGE_M)
