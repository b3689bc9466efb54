"""How the simulated Polaroid 6500 behaves; defaults say where they come from."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Self

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class SonarConfiguration(Configuration):
    """Model of one ping (sources: facts of the Polaroid 6500, Kuc and Siegel 1987, and the Scout's wire format)."""

    ping_period_s: float = parameter(
        0.06, "time between two firings; the Scout's rate 15 of 4 ms units", low=0.02, high=1.0, unit="s"
    )
    ray_spacing: float = parameter(
        math.radians(2.5), "angle between rays in the cone; sets how thin an object is found", low=0.002, high=0.1,
        unit="rad",
    )  # fmt: skip
    sure_incidence: float = parameter(
        math.radians(25.0), "incidence up to which a wall always answers (specular above 25-30 deg)", low=0.0,
        high=1.57, unit="rad",
    )  # fmt: skip
    last_incidence: float = parameter(
        math.radians(30.0), "incidence beyond which a wall never answers, but still blocks", low=0.0, high=1.57,
        unit="rad",
    )  # fmt: skip
    side_lobe_angle: float = parameter(
        math.radians(42.0), "outer end of the side lobes (flat walls were measured to echo out to there)", low=0.0,
        high=1.5, unit="rad",
    )  # fmt: skip
    side_lobe_range_m: float = parameter(
        1.5, "reach of the side lobes at normal incidence (assumed: weak means near)", low=0.0, high=6.5, unit="m"
    )
    side_lobe_probability: float = parameter(
        0.3, "chance of a side-lobe echo next to the main lobe, falling to 0 at its outer end (assumed)", low=0.0,
        high=1.0,
    )  # fmt: skip
    corner_wall_m: float = parameter(
        0.1, "shortest wall that makes a corner or an edge; shorter ones are roughness", low=0.0, high=5.0, unit="m"
    )
    edge_probability: float = parameter(0.3, "chance that a convex edge in the cone answers (weak)", low=0.0, high=1.0)
    edge_range_m: float = parameter(2.0, "reach of a convex edge's echo (assumed)", low=0.0, high=6.5, unit="m")
    noise_fraction: float = parameter(
        0.01, "standard deviation of a reading as a fraction of it (Polaroid: 1 %)", low=0.0, high=0.5
    )
    resolution_m: float = parameter(
        0.0254,
        "readings are cut to whole multiples (the Scout's inches); 0 for none",
        low=0.0,
        high=0.5,
        unit="m",
    )
    spurious_probability: float = parameter(
        0.01, "chance of a reading anywhere short of the true one (noise, cross-talk)", low=0.0, high=1.0
    )
    missing_probability: float = parameter(0.02, "chance that an echo is not heard", low=0.0, high=1.0)

    def noise_free(self) -> Self:
        """Return the same geometry of hearing without any chance: sharp specular limit, no weak echoes, no rounding."""
        return dataclasses.replace(
            self,
            last_incidence=self.sure_incidence,
            side_lobe_probability=0.0,
            edge_probability=0.0,
            noise_fraction=0.0,
            resolution_m=0.0,
            spurious_probability=0.0,
            missing_probability=0.0,
        )
