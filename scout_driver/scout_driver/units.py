"""The Scout's units against SI: tenths of inches, tenths of degrees, and what two wheel speeds make of a body.

Wheel speeds come as (right, left), the order of the wire.
"""

import math
from typing import NamedTuple

from hslam_types.sensing import Velocity

METRES_PER_UNIT = 0.00254
"""0.1 in: unit of position (0.1 in), of wheel speed (0.1 in/s) and of acceleration (0.1 in/s^2)."""
RADIANS_PER_UNIT = math.radians(0.1)
METRES_PER_INCH = 0.0254
REFERENCE_VOLTS = 5.0
PROCESSOR_DIVIDER = 12.0
MOTOR_DIVIDER = 12.85
"""Voltage dividers of the vendor's formula V = (2 + 3 raw/255) R/5."""


class Wheels(NamedTuple):
    """Wheel speeds in m/s."""

    right: float = 0.0
    left: float = 0.0


def wheels_from_velocity(velocity: Velocity, wheel_base_m: float) -> Wheels:
    """Return the wheel speeds that make ``velocity``."""
    half = 0.5 * wheel_base_m * velocity.turn
    return Wheels(velocity.forward + half, velocity.forward - half)


def velocity_from_wheels(wheels: Wheels, wheel_base_m: float) -> Velocity:
    """Return the body's velocity under ``wheels``."""
    return Velocity(0.5 * (wheels.right + wheels.left), (wheels.right - wheels.left) / wheel_base_m)


def within_wheel_speed(wheels: Wheels, wheel_speed_max_m_s: float) -> Wheels:
    """Scale both wheels alike, which keeps the curvature, so that neither is faster than the limit."""
    fastest = max(abs(wheels.right), abs(wheels.left))
    if fastest <= wheel_speed_max_m_s:
        return wheels
    scale = wheel_speed_max_m_s / fastest
    return Wheels(wheels.right * scale, wheels.left * scale)


def speed_units(speed_m_s: float) -> int:
    """Return a wheel speed in 0.1 in/s, rounded."""
    return round(speed_m_s / METRES_PER_UNIT)


def volts(raw: int, divider: float) -> float:
    """Return the voltage (V) behind a raw byte of the state frame."""
    return (2.0 + 3.0 * raw / 255.0) * divider / REFERENCE_VOLTS


def raw_volts(voltage: float, divider: float) -> int:
    """Return the raw byte of the state frame for a voltage (V), clamped to what a byte holds."""
    raw = (voltage * REFERENCE_VOLTS / divider - 2.0) * 255.0 / 3.0
    return min(255, max(0, round(raw)))
