"""What the emulated base stands on: the interface to a world, and the simplest one, an empty plane."""

import math
from typing import Protocol

from hslam_types.se2 import SE2, wrap
from scout_driver.units import Wheels, velocity_from_wheels


class Floor(Protocol):
    """A body in a world, moved by its wheels and seen by its encoders and sonars."""

    encoder_pose: SE2
    """What the encoders make of the motion; the base may define it anew."""

    @property
    def wheels(self) -> Wheels:
        """Wheel speeds as measured, which are not those asked for when a wall holds the body."""
        ...

    def drive(self, wheels: Wheels, duration_s: float) -> None:
        """Turn the wheels at these speeds for ``duration_s``."""
        ...

    def range_m(self, sensor: int) -> float:
        """Fire one sonar now; +inf if nothing is heard."""
        ...

    @property
    def bumped(self) -> bool:
        """Whether a wall holds the body now."""
        ...

    @property
    def volts(self) -> float:
        """Battery voltage."""
        ...


class EmptyPlane:
    """Nothing to meet and nothing to hear: perfect odometry on an endless floor."""

    def __init__(self, wheel_base_m: float = 0.34519) -> None:
        """Start at the origin."""
        self._wheel_base_m = wheel_base_m
        self.encoder_pose = SE2()
        self.true_pose = SE2()
        self._wheels = Wheels()

    @property
    def wheels(self) -> Wheels:
        """The wheel speeds asked for last."""
        return self._wheels

    def drive(self, wheels: Wheels, duration_s: float) -> None:
        """Move along an arc."""
        self._wheels = wheels
        forward, turn = velocity_from_wheels(wheels, self._wheel_base_m)
        step = _chord(forward * duration_s, turn * duration_s)
        self.encoder_pose = self.encoder_pose @ step
        self.true_pose = self.true_pose @ step

    def range_m(self, sensor: int) -> float:
        """Hear nothing."""
        del sensor
        return math.inf

    @property
    def bumped(self) -> bool:
        """Never."""
        return False

    @property
    def volts(self) -> float:
        """A full battery."""
        return 12.5


def _chord(length: float, angle: float) -> SE2:
    half = 0.5 * angle
    return SE2(length * math.cos(half), length * math.sin(half), wrap(angle))
