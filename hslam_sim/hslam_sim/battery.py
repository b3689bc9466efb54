"""The Scout's battery as its state frame shows it: a voltage in 256 steps."""

import math
from dataclasses import dataclass

from hslam_types.config import Configuration, parameter

REFERENCE_V = 12.85
"""Full scale of the motor voltage (vendor's generic formula V = (2 + 3 raw / 255) R / 5)."""


@dataclass(frozen=True)
class BatteryConfiguration(Configuration):
    """A lead battery that a run slowly empties (assumed values: none are published for the Scout)."""

    full_v: float = parameter(12.7, "voltage when full", low=6.0, high=12.85, unit="V")
    empty_v: float = parameter(11.0, "voltage when empty", low=6.0, high=12.85, unit="V")
    idle_hours: float = parameter(8.0, "time a standing robot lasts", low=0.1, high=1000.0, unit="h")
    range_km: float = parameter(12.0, "distance the charge lasts, standing aside", low=0.1, high=1000.0, unit="km")


def charge_left(config: BatteryConfiguration, elapsed_s: float, driven_m: float) -> float:
    """Return the share of the charge that is left, 0 to 1, after a time and a distance since it was full."""
    return max(0.0, 1.0 - elapsed_s / (3600.0 * config.idle_hours) - driven_m / (1000.0 * config.range_km))


def reported_voltage(config: BatteryConfiguration, charge: float) -> float:
    """Return the voltage (V) as the Scout reports it: cut to the steps of one byte."""
    volts = config.empty_v + charge * (config.full_v - config.empty_v)
    raw = math.floor((5.0 * volts / REFERENCE_V - 2.0) / 3.0 * 255.0 + 0.5)
    return (2.0 + 3.0 * min(max(raw, 0), 255) / 255.0) * REFERENCE_V / 5.0
