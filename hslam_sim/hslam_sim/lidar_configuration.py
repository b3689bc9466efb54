"""The simulated lidar: a planar scanner of time-of-flight ranges; defaults say where they come from."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Self

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class LidarConfiguration(Configuration):
    """A scanner mounted on the base; without beams there is none."""

    beams: int = parameter(0, "beams of a scan, evenly spread over the field of view; 0: no lidar", low=0, high=4000)
    field_of_view: float = parameter(
        math.tau, "angle from the first beam to the last, centred on the scanner's axis", low=0.1, high=math.tau,
        unit="rad",
    )  # fmt: skip
    forward_m: float = parameter(0.0, "the scanner's place before base_link's origin", low=-1.0, high=1.0, unit="m")
    range_min_m: float = parameter(0.12, "nearest range measured (LDS-01)", low=0.0, high=1.0, unit="m")
    range_max_m: float = parameter(8.0, "farthest range measured (small scanners)", low=0.5, high=100.0, unit="m")
    noise_m: float = parameter(
        0.01, "standard deviation of a range (LDS-01: 15 mm below 0.5 m, then 5 %; better scanners: 10 mm)", low=0.0,
        high=1.0, unit="m",
    )  # fmt: skip
    missing_probability: float = parameter(0.005, "chance that a beam does not answer (assumed)", low=0.0, high=1.0)
    dark_share: float = parameter(
        0.0, "share of the walls, in patches, that swallow the light and never answer", low=0.0, high=1.0
    )
    glass_share: float = parameter(0.0, "share of the walls, in patches, that light goes through", low=0.0, high=1.0)
    patch_m: float = parameter(0.5, "length of a dark or glass patch of wall", low=0.05, high=10.0, unit="m")

    def noise_free(self) -> Self:
        """Return the same scanner with exact ranges and no missing beams; what walls are made of stays."""
        return dataclasses.replace(self, noise_m=0.0, missing_probability=0.0)

    @property
    def bearing_step(self) -> float:
        """The angle (rad) from one beam to the next; on a full circle the last beam is no second first."""
        full = self.field_of_view > math.tau - 1e-6
        return self.field_of_view / (self.beams if full else max(self.beams - 1, 1))
