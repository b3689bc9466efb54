"""Every number of the GVG level, with unit, range, meaning and where it comes from."""

import math
from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class GvgConfig(Configuration):
    """How the robot maps what is near, follows the GVG and decides what is a node."""

    # The local obstacle map.
    memory_m: float = parameter(
        7.0, "a point is forgotten after this much travel (odometry drifts)", low=1.0, high=100.0, unit="m"
    )
    metres_per_radian: float = parameter(
        0.1, "travel that a turn of one radian counts for in the memory", low=0.0, high=2.0, unit="m/rad"
    )
    reach_m: float = parameter(
        3.5,
        "obstacles are minded out to this distance; of echoes from farther only those that other arcs place are kept",
        low=0.5,
        high=6.5,
        unit="m",
    )
    crossing_angle: float = parameter(
        math.radians(30.0),
        "crossing angle of a transversal intersection that is enough at any range (ATM)",
        low=0.1,
        high=1.5,
        unit="rad",
    )
    partner_travel_m: float = parameter(
        3.0, "arcs are compared with those of the last so many metres of travel", low=0.3, high=20.0, unit="m"
    )
    wall_step_m: float = parameter(
        0.15, "least distance between two soundings that give a wall's direction", low=0.05, high=1.0, unit="m"
    )
    wall_fill_m: float = parameter(
        0.55,
        "two echoes of one wall prove the wall between them up to this length; below a doorway",
        low=0.0,
        high=1.0,
        unit="m",
    )
    speckle_m: float = parameter(
        0.4, "an unconfirmed echo counts only with another one this near", low=0.05, high=2.0, unit="m"
    )
    body_m: float = parameter(
        0.19, "radius of the body: what lies nearer to its centre was never there", low=0.05, high=1.0, unit="m"
    )
    # The meaning of the map.
    passable_gap_m: float = parameter(
        0.85, "obstacles closer together than this are one obstacle", low=0.4, high=3.0, unit="m"
    )
    narrowest_gap_m: float = parameter(
        0.6, "the same beside near walls, which are known densely: a little wider than the body", low=0.3, high=3.0,
        unit="m",
    )  # fmt: skip
    separation: float = parameter(
        math.radians(60.0), "least angle between two closest points", low=0.3, high=2.0, unit="rad"
    )
    horizon_m: float = parameter(4.5, "the local graph is computed out to this distance", low=2.0, high=20.0, unit="m")
    chord_m: float = parameter(
        1.5, "a branch's bearing is that of its point at this distance from the node", low=0.3, high=5.0, unit="m"
    )
    # Control.
    cruise_m_s: float = parameter(0.4, "speed along an edge", low=0.02, high=1.0, unit="m/s")
    turn_rad_s: float = parameter(1.2, "fastest turn", low=0.1, high=3.0, unit="rad/s")
    equidistance_gain: float = parameter(0.8, "beta of the tracing and homing laws", low=0.01, high=5.0, unit="1/s")
    wide_m: float = parameter(
        2.8,
        "where both walls are farther than this, one wall is followed at this distance",
        low=0.5,
        high=6.0,
        unit="m",
    )
    home_tolerance_m: float = parameter(0.05, "a node is reached within this distance", low=0.005, high=0.5, unit="m")
    # Nodes.
    look_every_m: float = parameter(0.3, "travel between two looks at the local graph", low=0.05, high=2.0, unit="m")
    look_back_m: float = parameter(2.5, "nodes are recognised up to this far behind", low=0.3, high=5.0, unit="m")
    suppress_m: float = parameter(
        1.2, "a node just handled hides others within this distance", low=0.1, high=5.0, unit="m"
    )
    suppress_travel_m: float = parameter(5.0, "for so much travel", low=0.5, high=50.0, unit="m")
    probe_m: float = parameter(0.6, "length of a probing step along an edge", low=0.0, high=2.0, unit="m")
    dead_end_m: float = parameter(
        1.0, "shortest dead end that is an edge (true_gvg rule 5)", low=0.1, high=5.0, unit="m"
    )
    # Safety.
    stop_m: float = parameter(
        0.20,
        "room to an echo ahead below which the robot crawls, and stops if a second confirms it or at half this room",
        low=0.02,
        high=1.0,
        unit="m",
    )
    second_echo_m: float = parameter(
        0.30, "room to a second echo ahead below which it confirms the first", low=0.05, high=2.0, unit="m"
    )
    creep_m_s: float = parameter(0.06, "speed where the ring has not listened enough", low=0.01, high=1.0, unit="m/s")
    recoil_m: float = parameter(0.3, "way back along the trail after the body was held", low=0.05, high=2.0, unit="m")
