"""The numbers of the local map that sonars draw."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class SonarMapConfig(Configuration):
    """How far sonars are believed, and for how long."""

    cell_m: float = parameter(0.05, "side of a cell of free space", low=0.01, high=0.2, unit="m")
    reach_m: float = parameter(
        3.5, "echoes from farther away are no obstacles of the map", low=0.5, high=10.0, unit="m"
    )
    free_reach_m: float = parameter(
        3.0, "a cone shows free space out to this distance at most", low=0.5, high=10.0, unit="m"
    )
    margin_m: float = parameter(
        4.0, "room beyond the reach in which the map may move before it is copied", low=1.0, high=10.0, unit="m"
    )
    memory_m: float = parameter(
        6.0, "what was not heard again for so many metres of travel is forgotten", low=1.0, high=100.0, unit="m"
    )
    support: float = parameter(2.0, "pings that make an echo an obstacle, besides its own", low=1.0, high=20.0)
    doubtful_m: float = parameter(
        1.6, "a narrower gap between obstacles is a way only if pings went through it", low=0.0, high=3.0, unit="m"
    )
    refuted_m: float = parameter(
        3.0, "a narrower gap than this is none if pings ended at it; a wider one is always a way", low=0.0, high=5.0,
        unit="m",
    )  # fmt: skip
    gap_pings: int = parameter(2, "so many pings through a gap open it, so many that end at it shut it", low=1, high=20)
    trodden_m: float = parameter(
        4.0, "where the body was nothing is, for so many metres of travel", low=0.0, high=50.0, unit="m"
    )
    touch_memory_m: float = parameter(
        4.0, "an obstacle found by touch is kept for so many metres of travel", low=0.1, high=50.0, unit="m"
    )
