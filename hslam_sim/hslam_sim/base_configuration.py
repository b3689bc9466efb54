"""The simulated Nomadic Scout: size, limits and how its odometry goes wrong."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Self

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class BaseConfiguration(Configuration):
    """A differential drive with bounded wheels and the odometry errors of the paper's figure 3."""

    body_radius_m: float = parameter(0.19, "radius of the round body", low=0.05, high=1.0, unit="m")
    wheel_base_m: float = parameter(
        0.34519, "distance between the wheels (vendor's 0.118597 in a degree)", low=0.05, high=2.0, unit="m"
    )
    wheel_speed_limit: float = parameter(
        1.0, "a wheel's fastest speed (clamp of the Scout's drivers)", low=0.01, high=5.0, unit="m/s"
    )
    wheel_acceleration: float = parameter(
        1.0, "a wheel's acceleration limit (a setting of the Scout's AC command; assumed)", low=0.05, high=20.0,
        unit="m/s^2",
    )  # fmt: skip
    command_timeout_s: float = parameter(
        0.5, "the base stops when it has had no command for so long", low=0.0, high=60.0, unit="s"
    )
    slip_fraction: float = parameter(
        0.03, "standard deviation of a step's true length as a fraction of it (wheel slip)", low=0.0, high=0.5
    )
    turn_slip_fraction: float = parameter(
        0.02, "standard deviation of a step's true turn as a fraction of it (wheel slip; assumed)", low=0.0, high=0.5
    )
    heading_walk: float = parameter(
        math.radians(0.5), "random walk of the heading by distance driven (assumed)", low=0.0, high=1.0,
        unit="rad/sqrt(m)",
    )  # fmt: skip
    bias_least: float = parameter(
        math.radians(0.5), "least size of the run's constant rotation bias (corridors bend as in figure 3)", low=0.0,
        high=1.0, unit="rad/m",
    )  # fmt: skip
    bias_most: float = parameter(
        math.radians(2.0), "largest size of the rotation bias; size and sign are drawn once a run", low=0.0, high=1.0,
        unit="rad/m",
    )  # fmt: skip

    def noise_free(self) -> Self:
        """Return the same base with perfect odometry."""
        return dataclasses.replace(
            self, slip_fraction=0.0, turn_slip_fraction=0.0, heading_walk=0.0, bias_least=0.0, bias_most=0.0
        )
