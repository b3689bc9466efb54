"""The numbers of the level that follows the local graph."""

import math
from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class FollowConfig(Configuration):
    """How the robot drives along the local graph and when it is at a node."""

    body_m: float = parameter(0.19, "radius of the body", low=0.05, high=1.0, unit="m")
    margin_m: float = parameter(
        0.025, "room the body keeps to what is known, unless it is nearer already", low=0.0, high=0.5, unit="m"
    )
    metres_per_radian: float = parameter(
        0.1, "travel that a turn of one radian counts for in the memory", low=0.0, high=2.0, unit="m/rad"
    )
    cruise_m_s: float = parameter(0.4, "speed along an edge", low=0.02, high=2.0, unit="m/s")
    turn_rad_s: float = parameter(1.2, "fastest turn", low=0.1, high=3.0, unit="rad/s")
    home_m_s: float = parameter(0.2, "speed of the last approach to a node", low=0.02, high=1.0, unit="m/s")
    back_m_s: float = parameter(0.12, "speed of backing off from what stopped the body", low=0.02, high=1.0, unit="m/s")
    look_every_m: float = parameter(0.25, "travel between two looks at the local graph", low=0.05, high=2.0, unit="m")
    hear_every_m: float = parameter(0.1, "way between two scans that are mapped", low=0.0, high=1.0, unit="m")
    hear_every_rad: float = parameter(0.15, "turn between two scans that are mapped", low=0.0, high=1.0, unit="rad")
    look_back_m: float = parameter(1.2, "nodes passed unnoticed are found up to this far behind", low=0.0, high=5.0,
        unit="m")  # fmt: skip
    home_tolerance_m: float = parameter(0.08, "a meet point is reached within this distance", low=0.01, high=0.5,
        unit="m")  # fmt: skip
    end_tolerance_m: float = parameter(
        0.5, "a dead end is reached within its clearance, and this distance at most", low=0.1, high=2.0, unit="m"
    )
    chord_m: float = parameter(
        1.5, "a branch's bearing is that of its point at this distance from the node, or at clearance and half a metre",
        low=0.3, high=5.0, unit="m",
    )  # fmt: skip
    unlike_m: float = parameter(
        0.5, "a path farther than this from the one followed is another way", low=0.05, high=3.0, unit="m"
    )
    access_s: float = parameter(20.0, "without a graph in sight for so long, access is given up", low=1.0, high=600.0,
        unit="s")  # fmt: skip
    across_m: float = parameter(
        60.0, "in open space, where there is no graph, access drives straight on so far at most", low=0.0, high=1000.0,
        unit="m",
    )  # fmt: skip
    return_s: float = parameter(90.0, "a way back to the node left that takes longer is given up", low=1.0,
        high=3600.0, unit="s")  # fmt: skip
    blind_s: float = parameter(
        0.6, "without a scan for so long the robot stands until one comes", low=0.1, high=60.0, unit="s"
    )
    blocked_s: float = parameter(1.2, "stopped for so long, the robot backs off", low=0.1, high=60.0, unit="s")
    listening_turn: float = parameter(
        0.0, "turn to either side before a place is judged: what lies between sensors is heard",
        low=0.0, high=1.5,
        unit="rad",
    )  # fmt: skip
    listening_rad_s: float = parameter(0.5, "how fast that turn is", low=0.05, high=3.0, unit="rad/s")
    aligned: float = parameter(
        math.radians(4.0), "a turn to a branch ends within this angle", low=0.005, high=0.5, unit="rad"
    )


@dataclass(frozen=True)
class RingFollowConfig(FollowConfig):
    """The same for a ring of sonars, which shows a place bit by bit."""

    cruise_m_s: float = parameter(0.3, "speed along an edge", low=0.02, high=2.0, unit="m/s")
    look_every_m: float = parameter(0.2, "travel between two looks at the local graph", low=0.05, high=2.0, unit="m")
    look_back_m: float = parameter(2.5, "nodes passed unnoticed are found up to this far behind", low=0.0, high=5.0,
        unit="m")  # fmt: skip
    listening_turn: float = parameter(
        0.4, "turn to either side before a place is judged: what lies between sensors is heard",
        low=0.0, high=1.5,
        unit="rad",
    )  # fmt: skip
