"""Paths: lengths, chords and how far two of them are apart."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_gvg.local_graph.polyline import apart_m, chord_bearing, length_m, nearest, resampled, turned_from
from hslam_types.se2 import Array


def straight(bearing: float, length: float, x: float = 0.0, y: float = 0.0) -> Array:
    """Return a straight path from a place, k x 3."""
    along = np.linspace(0.0, length, max(2, round(length / 0.08) + 1))
    return np.column_stack((x + along * math.cos(bearing), y + along * math.sin(bearing), np.full(len(along), 0.5)))


@given(st.floats(-3.1, 3.1), st.floats(0.2, 8.0))
def test_resampling_keeps_ends_and_length(bearing: float, length: float) -> None:
    path = straight(bearing, length)[[0, -1]]
    dense = resampled(path)
    assert np.allclose(dense[[0, -1]], path)
    assert length_m(dense) == pytest.approx(length)
    assert np.hypot(*np.diff(dense[:, :2], axis=0).T).max() <= 0.08 + 1e-9


@given(st.floats(-3.1, 3.1), st.floats(0.3, 1.4))
def test_a_chord_points_to_where_the_path_leaves_the_circle(bearing: float, chord_m: float) -> None:
    bent = np.vstack((straight(bearing, 1.5), straight(bearing + 1.0, 2.0, *straight(bearing, 1.5)[-1, :2])[1:]))
    assert chord_bearing(bent, chord_m) == pytest.approx(bearing, abs=1e-6)
    if chord_m < 1.0:
        assert chord_bearing(straight(bearing, 0.5 * chord_m), chord_m) == pytest.approx(bearing, abs=1e-6)


def test_a_chord_beyond_the_bend_sees_both_parts() -> None:
    bent = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 3.0, 1.0]])
    assert chord_bearing(resampled(bent), math.sqrt(2.0)) == pytest.approx(math.pi / 4, abs=0.01)


def test_paths_side_by_side_are_as_far_apart_as_they_are() -> None:
    assert apart_m(straight(0.0, 2.0), straight(0.0, 2.0, 0.0, 0.3), 2.0) == pytest.approx(0.3)


def test_paths_that_part_differ_more_the_farther_they_are_compared() -> None:
    one, other = straight(0.0, 4.0), straight(0.5, 4.0)
    assert apart_m(one, other, 1.0) < apart_m(one, other, 3.0)


def test_nothing_to_compare_is_infinitely_apart() -> None:
    assert apart_m(straight(0.0, 0.1), straight(0.0, 4.0), 2.0) == math.inf


@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_the_turn_is_the_angle_between_direction_and_path(bearing: float, direction: float) -> None:
    expected = abs(math.remainder(bearing - direction, math.tau))
    assert turned_from(straight(bearing, 2.0), direction, 0.8) == pytest.approx(expected, abs=1e-6)


def test_the_nearest_point_is_found_with_its_distance() -> None:
    index, away = nearest(straight(0.0, 2.0), 1.0, 0.4)
    assert away == pytest.approx(0.4, abs=0.01)
    assert straight(0.0, 2.0)[index, 0] == pytest.approx(1.0, abs=0.05)
