"""Calibration of a base whose counters and wheels are not what they say."""

import math

import numpy as np
import pytest

from hslam_types.se2 import SE2, wrap
from scout_driver.calibration import CalibrationError, Calibrator, Leg, calibrate
from scout_driver.config import DriverConfig
from scout_driver.driver import ScoutDriver
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.faults import Faults
from scout_driver.emulator.floor import EmptyPlane
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.loopback import VirtualClock, opener, wait_until
from scout_driver.units import Wheels, velocity_from_wheels

WORN = 0.97
"""The wheels roll less far than the encoders believe."""
TRUE_BASE_M = 0.335


class WornBase(EmptyPlane):
    """Smaller wheels and a narrower wheel base than the base's own reckoning assumes."""

    def drive(self, wheels: Wheels, duration_s: float) -> None:
        """Move; the encoders tell one story, the floor another."""
        truth = self.true_pose
        super().drive(wheels, duration_s)
        forward, turn = velocity_from_wheels(Wheels(wheels.right * WORN, wheels.left * WORN), TRUE_BASE_M)
        half = SE2(0.0, 0.0, 0.5 * turn * duration_s)
        self.true_pose = truth @ half @ SE2(forward * duration_s, 0.0, 0.0) @ half


def test_finds_the_scales_and_the_wheel_base() -> None:
    floor, config, clock = WornBase(), EmulatorConfig(), VirtualClock()
    line = EmulatedLine(EmulatedBase(floor, config), config, Faults(FaultConfig(), np.random.default_rng(0)))
    driver = ScoutDriver(DriverConfig(), clock, opener(line, clock))
    driver.enable()
    calibrator = Calibrator(driver, lambda now_s: wait_until(line, clock, now_s + 0.04))
    straight = calibrator.line(2.0)
    measured = floor.true_pose.x
    turns = calibrator.turns(5)
    found = calibrate(straight, measured, turns, floor.true_pose.theta)
    assert found.distance_scale == pytest.approx(WORN, abs=0.003)
    assert found.rotation_scale == pytest.approx(WORN * 0.34519 / TRUE_BASE_M, abs=0.002)
    assert found.wheel_base_m == pytest.approx(TRUE_BASE_M, rel=0.01)


def test_a_base_that_does_not_move_is_an_error() -> None:
    floor, config, clock = EmptyPlane(), EmulatorConfig(), VirtualClock()
    base = EmulatedBase(floor, config)
    base.emergency_stop = True
    line = EmulatedLine(base, config, Faults(FaultConfig(), np.random.default_rng(0)))
    driver = ScoutDriver(DriverConfig(), clock, opener(line, clock))
    driver.enable()
    with pytest.raises(CalibrationError, match="emergency stop"):
        Calibrator(driver, lambda now_s: wait_until(line, clock, now_s + 0.04)).line(1.0)


def test_the_residual_angle_is_taken_the_short_way() -> None:
    turned = 10.0 * math.pi + 0.05
    found = calibrate(Leg(2.0, 0.0, 0.0), 2.0, Leg(0.0, turned, 0.34519 * turned), wrap(turned) - 0.1)
    assert found.rotation_scale == pytest.approx(1.0 - 0.1 / turned)


def test_a_slip_of_the_pen_is_noticed() -> None:
    with pytest.raises(CalibrationError, match="distance"):
        calibrate(Leg(2.0, 0.0, 0.0), 20.0, Leg(0.0, 31.4, 10.8), 0.0)
