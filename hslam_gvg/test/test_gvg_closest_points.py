"""Closest points and control laws on corridors and junctions with known answers."""

import math

import numpy as np
import pytest
from drawn_walls import CROSSING, HALF, L_CORNER, T_JUNCTION, points_of
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hslam_gvg.closest_points import ahead, beside, closest_points
from hslam_gvg.control import access, drive, follow, home, trace
from hslam_types.se2 import SE2, wrap

SEPARATION = math.radians(60.0)


def test_a_corridor_has_two_closest_points() -> None:
    found = closest_points(points_of(T_JUNCTION), -5.0, 0.2, 3.0, SEPARATION)
    assert [c.distance_m for c in found] == pytest.approx([1.0, 1.4], abs=0.01)
    assert [c.bearing for c in found] == pytest.approx([math.pi / 2.0, -math.pi / 2.0], abs=0.1)


def test_a_crossing_has_four() -> None:
    found = closest_points(points_of(CROSSING), 0.0, 0.0, 3.0, SEPARATION)
    assert len(found) == 4
    assert all(c.distance_m == pytest.approx(math.hypot(HALF, HALF), abs=0.01) for c in found)


def test_the_wall_ahead_is_on_no_side() -> None:
    left, right = beside(points_of(L_CORNER), -2.0, 0.0, 0.0, 5.0)
    assert left is not None
    assert right is not None
    assert left.distance_m == pytest.approx(HALF, abs=0.01)
    assert right.distance_m == pytest.approx(HALF, abs=0.1)
    assert ahead(points_of(L_CORNER), -2.0, 0.0, 0.0, 0.3, 5.0) == pytest.approx(3.2, abs=0.01)


@settings(max_examples=25, deadline=None)
@given(st.floats(-0.8, 0.8), st.floats(-0.6, 0.6))
def test_tracing_settles_between_the_walls(y: float, course: float) -> None:
    points, x = points_of(T_JUNCTION, step_m=0.05), -7.0
    for _ in range(60):
        left, right = beside(points, x, y, course, 4.0)
        assert left is not None
        assert right is not None
        vx, vy = trace(left, right, course, 0.4, 0.8)
        x, y = x + 0.1 * vx, y + 0.1 * vy
    assert abs(y) < 0.05
    assert x > -5.5


@pytest.mark.parametrize("start", [(0.5, 0.2), (-0.4, -0.6), (0.1, 0.5)])
def test_homing_ends_where_three_obstacles_are_equally_far(start: tuple[float, float]) -> None:
    points, (x, y) = points_of(T_JUNCTION, step_m=0.02), start
    for _ in range(60):
        near = closest_points(points, x, y, 4.0, SEPARATION, most=3)
        vx, vy = home(near, 0.8)
        x, y = x + 0.2 * vx, y + 0.2 * vy
    # Equally far from the wall y = 1.2 and the corners (+-1.2, -1.2).
    assert (x, y) == pytest.approx((0.0, -0.3), abs=0.03)


def test_access_climbs_away_and_one_wall_can_be_followed() -> None:
    wall = closest_points(points_of(((-8, -1.0, 8, -1.0),), step_m=0.02), 0.0, 0.0, 3.0, SEPARATION)[0]
    assert access(wall, 0.3) == pytest.approx((0.0, 0.3), abs=0.05)
    vx, vy = follow(wall, 2.0, 0.0, 0.4, 0.8)
    assert vx == pytest.approx(0.4, abs=0.05)
    assert vy > 0.5


@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_the_drive_turns_the_shorter_way(heading: float, wanted: float) -> None:
    command = drive(SE2(0.0, 0.0, heading), math.cos(wanted), math.sin(wanted), 1.0)
    error = wrap(wanted - heading)
    assert command.turn * error >= 0.0
    assert abs(command.turn) <= 1.0
    assert command.forward >= 0.0


@pytest.mark.parametrize("heading", [0.0, 2.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_stands_in_a_cone_ahead_or_behind_is_on_neither_side(heading: float, side: float) -> None:
    cone = math.asin(0.25)
    for off, aside in ((cone + 0.02, True), (cone - 0.02, False), (math.pi - cone + 0.02, False), (2.6, True)):
        azimuth = heading + side * off
        point = np.array([[1.0 + math.cos(azimuth), 2.0 + math.sin(azimuth)]])
        left, right = beside(point, 1.0, 2.0, heading, 3.0)
        there, other = (left, right) if side > 0.0 else (right, left)
        assert other is None
        assert (there is not None) is aside
        if there is not None:
            assert there.distance_m == pytest.approx(1.0)
            assert abs(wrap(there.bearing - azimuth)) < 1e-9


def test_beside_is_who_is_nearest_within_reach() -> None:
    points = np.array([[0.0, 2.0], [0.5, 1.0], [0.0, -3.1]])
    left, right = beside(points, 0.0, 0.0, 0.0, 3.0)
    assert left is not None
    assert left.distance_m == pytest.approx(math.hypot(0.5, 1.0))
    assert right is None


@given(st.floats(-3.1, 3.1), st.floats(-4.0, 4.0), st.floats(-1.0, 1.0))
def test_ahead_is_a_strip_of_its_width_and_length(heading: float, forward: float, left: float) -> None:
    here = SE2(1.0, 2.0, heading)
    assume(abs(abs(left) - 0.3) > 1e-6 and abs(forward) > 1e-6)
    free_m = ahead(np.array([here.apply(forward, left)]), *here, 0.3, 2.0)
    assert free_m == pytest.approx(min(forward, 2.0) if abs(left) < 0.3 and forward > 0.0 else 2.0)
