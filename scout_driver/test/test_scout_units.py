"""Units, wheel speeds and limits."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.errors import ConfigurationError
from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.ramp import Ramp
from scout_driver.units import (
    MOTOR_DIVIDER,
    Wheels,
    raw_volts,
    speed_units,
    velocity_from_wheels,
    volts,
    wheels_from_velocity,
    within_wheel_speed,
)

BASE_M = DriverConfig().wheel_base_m
speeds = st.floats(-1.0, 1.0)


def test_turning_left_runs_the_right_wheel_forward() -> None:
    right, left = wheels_from_velocity(Velocity(0.0, 1.0), BASE_M)
    assert right == pytest.approx(0.5 * BASE_M)
    assert left == -right


def test_wheel_base_agrees_with_the_vendors_inches_per_degree() -> None:
    turn = math.radians(1.0)
    right, _ = wheels_from_velocity(Velocity(0.0, turn), BASE_M)
    assert right / 0.0254 == pytest.approx(0.118597, rel=1e-4)


@given(speeds, speeds)
def test_wheels_and_velocity_are_inverse(forward: float, turn: float) -> None:
    back = velocity_from_wheels(wheels_from_velocity(Velocity(forward, turn), BASE_M), BASE_M)
    assert back == pytest.approx((forward, turn), abs=1e-12)


@given(speeds, speeds)
def test_limiting_keeps_the_curvature(right: float, left: float) -> None:
    limited = within_wheel_speed(Wheels(right, left), 0.3)
    assert max(map(abs, limited)) <= 0.3 + 1e-12
    assert limited.right * left == pytest.approx(limited.left * right, abs=1e-12)


def test_wheel_speeds_are_rounded_not_cut() -> None:
    assert [speed_units(0.00254 * units) for units in (1.4, 1.6, -1.6)] == [1, 2, -2]


@given(st.integers(0, 255))
def test_voltages_round_trip(raw: int) -> None:
    assert raw_volts(volts(raw, MOTOR_DIVIDER), MOTOR_DIVIDER) == raw


@given(speeds, st.floats(-3.0, 3.0), st.floats(0.001, 0.5))
def test_the_ramp_never_exceeds_its_limits_and_arrives(forward: float, turn: float, elapsed_s: float) -> None:
    ramp, before = Ramp(0.5, 2.5), Velocity()
    for _ in range(math.ceil(4.0 / elapsed_s)):
        now = ramp.toward(Velocity(forward, turn), elapsed_s)
        assert abs(now.forward) - abs(before.forward) <= 0.5 * elapsed_s + 1e-12
        assert abs(now.turn) - abs(before.turn) <= 2.5 * elapsed_s + 1e-12
        before = now
    assert before == Velocity(forward, turn)


def test_slowing_down_is_asked_for_at_once_and_a_reversal_passes_through_rest() -> None:
    ramp = Ramp(0.5, 2.5)
    for _ in range(20):
        ramp.toward(Velocity(0.4, -1.0), 0.1)
    assert ramp.toward(Velocity(0.1, 0.0), 0.1) == Velocity(0.1, 0.0)
    assert ramp.toward(Velocity(-0.4, 0.0), 0.1) == Velocity(-0.05, 0.0)


@pytest.mark.parametrize("order", ["", "0 1 1", "0 16", "a b", "0 -1"])
def test_a_wrong_firing_order_is_refused(order: str) -> None:
    with pytest.raises(ConfigurationError, match="sonar_order"):
        DriverConfig(sonar_order=order)
