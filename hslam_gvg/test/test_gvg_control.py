"""The control laws do what their equations say: G decays at the gain, the speed along the edge is the one asked for."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hslam_gvg.closest_points import ClosestPoint
from hslam_gvg.control import TURN_FIRST, TURN_GAIN, access, drive, follow, home, trace
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity

ANGLES = st.floats(-3.1, 3.1)
DISTANCES = st.floats(0.3, 3.0)
SPEEDS = st.floats(0.05, 0.5)
GAINS = st.floats(0.1, 2.0)
APART = math.radians(60.0)


def rate(obstacle: ClosestPoint, velocity: tuple[float, float]) -> float:
    """Return d/dt of the distance to an obstacle."""
    return float(np.dot(obstacle.gradient, velocity))


@given(DISTANCES, ANGLES, SPEEDS)
def test_access_climbs_at_the_speed_asked_for(distance_m: float, bearing: float, speed: float) -> None:
    obstacle = ClosestPoint(distance_m, bearing)
    assert rate(obstacle, access(obstacle, speed)) == pytest.approx(speed)


@given(DISTANCES, DISTANCES, ANGLES, st.floats(APART, 2.0 * math.pi - APART), ANGLES, SPEEDS, GAINS)
def test_tracing_evens_two_obstacles_out_at_the_gain(
    near_m: float, far_m: float, bearing: float, apart: float, heading: float, alpha: float, beta: float
) -> None:
    """Whatever the angle between them: dG/dt = -beta G; along the edge the robot goes at alpha, the way it heads."""
    first, second = ClosestPoint(near_m, bearing), ClosestPoint(far_m, wrap(bearing + apart))
    velocity = trace(first, second, heading, alpha, beta)
    assert rate(first, velocity) - rate(second, velocity) == pytest.approx(-beta * (near_m - far_m), abs=1e-9)
    along = bearing + 0.5 * apart
    speed = velocity[0] * math.cos(along) + velocity[1] * math.sin(along)
    assert abs(speed) == pytest.approx(alpha)
    assume(abs(math.cos(along - heading)) > 1e-6)
    assert speed * math.cos(along - heading) > 0.0


def test_tracing_two_points_of_one_wall_goes_straight_on() -> None:
    wall = ClosestPoint(1.0, 0.3)
    assert trace(wall, wall, 2.0, 0.4, 0.8) == pytest.approx((0.4 * math.cos(2.0), 0.4 * math.sin(2.0)))


@given(DISTANCES, DISTANCES, ANGLES, ANGLES, SPEEDS, GAINS)
def test_following_one_wall_comes_to_the_distance_at_the_gain(
    distance_m: float, wanted_m: float, bearing: float, heading: float, alpha: float, beta: float
) -> None:
    wall = ClosestPoint(distance_m, bearing)
    velocity = follow(wall, wanted_m, heading, alpha, beta)
    assert rate(wall, velocity) == pytest.approx(-beta * (distance_m - wanted_m), abs=1e-9)
    along = -velocity[0] * math.sin(bearing) + velocity[1] * math.cos(bearing)
    assert abs(along) == pytest.approx(alpha)
    assume(abs(math.sin(heading - bearing)) > 1e-6)
    assert along * math.sin(heading - bearing) > 0.0


@given(DISTANCES, DISTANCES, DISTANCES, ANGLES, st.floats(1.2, 2.8), st.floats(1.2, 2.8), GAINS)
def test_homing_evens_three_obstacles_out_at_the_gain(
    a_m: float, b_m: float, c_m: float, bearing: float, to_b: float, to_c: float, beta: float
) -> None:
    a, b, c = (
        ClosestPoint(a_m, bearing), ClosestPoint(b_m, wrap(bearing + to_b)), ClosestPoint(c_m, wrap(bearing - to_c))
    )  # fmt: skip
    velocity = home((a, b, c), beta)
    assert rate(a, velocity) - rate(b, velocity) == pytest.approx(-beta * (a_m - b_m), abs=1e-6)
    assert rate(a, velocity) - rate(c, velocity) == pytest.approx(-beta * (a_m - c_m), abs=1e-6)


def test_homing_on_obstacles_that_hardly_differ_does_not_leap() -> None:
    """Two of three obstacles in nearly one direction say nothing of how far to go aside."""
    near = [ClosestPoint(1.0, 0.0), ClosestPoint(1.1, math.pi), ClosestPoint(1.3, math.pi - 0.1)]
    assert math.hypot(*home(near, 1.0)) < 0.2


@given(ANGLES, ANGLES, SPEEDS, st.booleans())
def test_the_drive_turns_the_velocity_into_pace_and_turn(
    heading: float, wanted: float, speed: float, backwards: bool
) -> None:
    fastest = 1.0
    command = drive(SE2(0.0, 0.0, heading), speed * math.cos(wanted), speed * math.sin(wanted), fastest, backwards)
    error = wrap(wanted - heading + (math.pi if backwards else 0.0))
    assume(math.pi - abs(error) > 1e-6)
    assert command.turn == pytest.approx(max(-fastest, min(fastest, TURN_GAIN * error)))
    forward = speed * math.cos(error) if abs(error) < TURN_FIRST else 0.0
    assert command.forward == pytest.approx(-forward if backwards else forward)


def test_where_nothing_is_to_do_the_drive_stands() -> None:
    assert drive(SE2(0.0, 0.0, 1.0), 0.0, 0.0, 1.0) == Velocity()
