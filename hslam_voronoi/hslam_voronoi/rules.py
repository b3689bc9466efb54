"""The numbers that decide which parts of a Voronoi diagram are nodes and edges of the reduced GVG."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class ReductionRules(Configuration):
    """Thresholds of the reduction; each was chosen so that the graph holds still under noise on thirteen plans."""

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
        5.0, "what is farther than this from every wall is open space, which counts as an obstacle", low=1.0,
        high=100.0, unit="m",
    )  # fmt: skip
    """The extended Voronoi graph (Beeson, Jong and Kuipers, 2005): a hall wider than the sensor reaches has no
    ridge in sight; its open middle, taken for an obstacle, gives one along the walls that a robot can see."""
