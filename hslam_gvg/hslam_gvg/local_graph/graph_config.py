"""The numbers of the local graph."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class LocalGraphConfig(Configuration):
    """How much of the surroundings becomes a graph, and how wide a way must be; the rules are the truth's own."""

    horizon_m: float = parameter(9.0, "the graph is made out to this distance at most", low=2.0, high=30.0, unit="m")
    horizon_least_m: float = parameter(3.5, "and to this at least", low=1.0, high=30.0, unit="m")
    horizon_clearances: float = parameter(
        2.2, "between the two: to so many clearances of the robot's place, and 2 m", low=1.0, high=10.0
    )
    site_m: float = parameter(
        0.08, "obstacle points closer together than about this are averaged", low=0.02, high=0.3, unit="m"
    )
    into_free_m: float = parameter(
        3.0, "a ridge whose next vertex is not known is followed so far while the space on it is free", low=0.0,
        high=10.0, unit="m",
    )  # fmt: skip
    exit_credit: float = parameter(
        1.0, "how far a branch is taken to go on beyond where the known ends, in widths of its mouth", low=0.0, high=5.0
    )
    exits_by_ratio: bool = parameter(
        False, "a branch into the unknown must be long for the width of the place it leaves, as one that is known"
    )
    passable_m: float = parameter(
        0.22, "clearance a way needs: the body's radius and a margin for driving", low=0.05, high=2.0, unit="m"
    )


@dataclass(frozen=True)
class RingGraphConfig(LocalGraphConfig):
    """The same for a ring of sonars, which hears walls abreast and free space ahead."""

    horizon_m: float = parameter(5.0, "the graph is made out to this distance at most", low=2.0, high=30.0, unit="m")
    exit_credit: float = parameter(
        3.0, "how far a branch is taken to go on beyond where the known ends, in widths of its mouth", low=0.0, high=5.0
    )
    exits_by_ratio: bool = parameter(
        True, "a branch into the unknown must be long for the width of the place it leaves, as one that is known"
    )
