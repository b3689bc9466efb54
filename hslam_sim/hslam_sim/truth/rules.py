"""The numbers that decide what the true reduced GVG of a floor is."""

from dataclasses import dataclass

from hslam_types.config import parameter
from hslam_voronoi.rules import ReductionRules


@dataclass(frozen=True)
class Rules(ReductionRules):
    """The rules of the reduction, and how walls become ridges."""

    sample_m: float = parameter(0.05, "spacing of the wall samples", low=0.01, high=0.5, unit="m")
    reach_m: float = parameter(
        0.25, "clearance a place needs to be reached: robot radius + 0.06 m", low=0.05, high=2.0, unit="m"
    )
    bend_m: float = parameter(
        0.2,
        "two samples of one outline make a ridge if the way along it exceeds the chord by this",
        low=0.01,
        high=2.0,
        unit="m",
    )
