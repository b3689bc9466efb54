"""The numbers that decide which parts of a Voronoi diagram are nodes of the reduced GVG."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class Rules(Configuration):
    """Thresholds of the reduction; each was chosen so that the graph holds still under noise on thirteen plans."""

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
    spur_least_m: float = parameter(1.0, "a spur's extent must reach this at least", low=0.1, high=10.0, unit="m")
    spur_ratio: float = parameter(
        1.5, "a spur's extent must reach this many clearances of its meet point", low=0.1, high=10.0
    )
    spur_beyond_m: float = parameter(
        1.0, "but no more than its clearance and this: halls keep their corridors", low=0.1, high=10.0, unit="m"
    )
    merge_ratio: float = parameter(1.0, "meet points nearer than this many clearances are one", low=0.1, high=10.0)
    span_ratio: float = parameter(2.0, "no merged cluster is wider than this many clearances", low=0.1, high=10.0)
    loop_ratio: float = parameter(
        3.2, "a loop at one node shorter than this many clearances is none", low=0.1, high=20.0
    )
    open_m: float = parameter(
        6.0, "beyond this clearance (the sonar's reach) space is open", low=1.0, high=100.0, unit="m"
    )
