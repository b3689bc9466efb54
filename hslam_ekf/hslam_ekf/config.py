"""What the edge-map filter can be told: noise of the base, gates, evidence asked of a landmark."""

import math
from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class EkfConfig(Configuration):
    """Parameters of one edge-map filter; standard deviations unless said otherwise."""

    slip_per_metre: float = parameter(
        0.02, "Position error along and across the path after one metre driven; grows with the root of the way.",
        low=0.0, high=1.0, unit="m",
    )  # fmt: skip
    turn_slip_per_metre: float = parameter(
        math.radians(0.7), "Heading error after one metre driven, beyond the constant bias; grows with the root.",
        low=0.0, high=1.0, unit="rad",
    )  # fmt: skip
    turn_slip_per_radian: float = parameter(
        0.03, "Heading error after one radian turned; grows with the root of the angle.", low=0.0, high=1.0, unit="rad"
    )
    turn_bias_per_metre: float = parameter(
        math.radians(1.2), "Prior of the constant rotation bias of the odometry (0 switches its estimation off).",
        low=0.0, high=0.5, unit="rad/m",
    )  # fmt: skip
    odometry_covariances: bool = parameter(
        True, "Weigh odometry by the covariances it comes with, without a bias; the above where none can be believed."
    )
    homing_m: float = parameter(
        0.02, "Error of a meet point's announced position relative to the robot.", low=0.0, high=1.0, unit="m"
    )
    accept_gate: float = parameter(
        11.8, "A sighting whose chi (eq. 3, 2 degrees of freedom) is below this is of that landmark: 99.7 %.",
        low=1.0, high=100.0,
    )  # fmt: skip
    new_gate: float = parameter(
        30.0, "A sighting whose least chi exceeds this starts a landmark; in between it is dropped.",
        low=1.0, high=1000.0,
    )  # fmt: skip
    confirm_sightings: int = parameter(3, "Sightings that make a tentative landmark a confirmed one.", low=1, high=100)
    tentative_misses: int = parameter(
        3, "Looks in a row without it that delete a tentative landmark within range.", low=1, high=100
    )
    keep_sightings: int = parameter(4, "Sightings a landmark needs to stay in the edge-map.", low=1, high=1000)
    keep_fraction: float = parameter(
        0.3, "Least share of the looks that ought to have shown a landmark and did.", low=0.0, high=1.0
    )
