"""A guided calibration: the base drives a line and turns on the spot, a person measures, the scales follow.

Encoders and wheels are off by a per cent or two from base to base (two published wheel bases differ by
1.4 %).  The base's heading is its own affair, so distance, rotation and wheel base are three figures.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity
from scout_driver.driver import Reading, ScoutDriver
from scout_driver.errors import ScoutError
from scout_driver.units import METRES_PER_UNIT

SETTLE_S = 1.0
STALL_S = 10.0
"""A leg may take so much longer than its speed says."""


class CalibrationError(ScoutError):
    """The base did not do what it was asked to, or the measurement cannot be right."""


@dataclass(frozen=True, slots=True)
class Leg:
    """What the base reported of one motion."""

    distance_m: float
    """Along the path, by the counters."""
    turned_rad: float
    """By the base's heading, whole turns included."""
    wheel_difference_m: float
    """How much farther the right wheel rolled than the left, by the reported wheel speeds."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """The driver's parameters that follow."""

    distance_scale: float
    rotation_scale: float
    wheel_base_m: float


class Calibrator:
    """Drives the legs; ``wait`` lets a cycle's rest pass (a real base's takes time, an emulated one's none)."""

    def __init__(self, driver: ScoutDriver, wait: Callable[[float], None]) -> None:
        """Take an enabled driver whose scales are 1."""
        self._driver, self._wait = driver, wait

    def line(self, distance_m: float, speed_m_s: float = 0.2) -> Leg:
        """Drive straight on by about ``distance_m``; raises CalibrationError if the base does not."""
        return self._leg(Velocity(speed_m_s, 0.0), lambda leg: leg.distance_m >= distance_m, distance_m / speed_m_s)

    def turns(self, count: int, rate_rad_s: float = 0.5) -> Leg:
        """Turn on the spot, counter-clockwise, about ``count`` times; raises CalibrationError if the base does not."""
        angle = 2.0 * math.pi * count
        return self._leg(Velocity(0.0, rate_rad_s), lambda leg: leg.turned_rad >= angle, angle / rate_rad_s)

    def _leg(self, command: Velocity, done: Callable[[Leg], bool], lasts_s: float) -> Leg:
        """Command until ``done``, come to rest, and return what was reported in all."""
        clock, leg, before = self._driver.now, Leg(0.0, 0.0, 0.0), None
        until_s, resting = clock() + lasts_s + STALL_S, False
        while clock() < until_s:
            self._driver.command(Velocity() if resting else command)
            reading = self._driver.cycle()
            if reading is not None:
                leg = _longer(leg, before, reading) if before is not None else leg
                before = reading
                if not resting and done(leg):
                    resting, until_s = True, clock() + SETTLE_S
            self._wait(clock())
        if not resting:
            hold = self._driver.hold()
            raise CalibrationError(f"the base did not finish the leg ({hold.value if hold else 'too slow'})")
        return leg


def _longer(leg: Leg, before: Reading, after: Reading) -> Leg:
    """Return a leg with one more step."""
    step = before.base_in_odom.to(after.base_in_odom)
    seconds = after.stamp_s - before.stamp_s
    apart = 0.5 * (before.state.right + after.state.right - before.state.left - after.state.left)
    return Leg(
        leg.distance_m + math.hypot(step.x, step.y),
        leg.turned_rad + wrap(step.theta),
        leg.wheel_difference_m + apart * METRES_PER_UNIT * seconds,
    )


def calibrate(line: Leg, measured_m: float, turns: Leg, beyond_rad: float) -> Calibration:
    """Return the parameters from what was reported and measured; raises CalibrationError if that cannot be.

    Args:
        line: the straight leg.
        measured_m: its length on the floor.
        turns: the leg of turns.
        beyond_rad: where the base really faces after it, counter-clockwise from where it faced before, whole
            turns left out.
    """
    reported = turns.turned_rad
    true = reported + wrap(beyond_rad - reported)
    distance_scale, rotation_scale = measured_m / line.distance_m, true / reported
    wheel_base = abs(turns.wheel_difference_m) * distance_scale / abs(true)
    for name, scale in (("distance", distance_scale), ("rotation", rotation_scale)):
        if not 0.8 <= scale <= 1.25:
            raise CalibrationError(f"a {name} scale of {scale:.3f} cannot be right; measure again")
    return Calibration(distance_scale, rotation_scale, wheel_base)
