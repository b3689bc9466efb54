"""The numbers of the local map that a scanner draws."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class ScanMapConfig(Configuration):
    """How far and how finely the surroundings are kept, and for how long."""

    cell_m: float = parameter(0.05, "side of a cell", low=0.01, high=0.2, unit="m")
    reach_m: float = parameter(9.0, "the map is drawn out to this distance", low=2.0, high=30.0, unit="m")
    margin_m: float = parameter(
        1.5, "room beyond the reach in which the map may move before it is copied", low=1.0, high=10.0, unit="m"
    )
    memory_m: float = parameter(
        8.0, "what was not seen again for so many metres of travel is forgotten", low=1.0, high=100.0, unit="m"
    )
    bridged_m: float = parameter(
        0.45, "two ends farther apart are never one wall: a body could pass", low=0.05, high=1.0, unit="m"
    )
    swallowed_m: float = parameter(
        1.0, "silent beams across less than this between two answers show neither wall nor free space", low=0.0,
        high=10.0, unit="m",
    )  # fmt: skip
    match_gate_m: float = parameter(
        0.08, "an end of a scan this near to the map is matched with it, and the map kept straight; 0: odometry is all",
        low=0.0, high=1.0, unit="m",
    )  # fmt: skip
    slip_per_metre: float = parameter(
        0.1, "what odometry may be wrong by, of the way between two scans", low=0.001, high=1.0
    )
    bend_per_metre: float = parameter(0.06, "by how much its heading may be wrong", low=0.001, high=1.0, unit="rad/m")
    turn_slip: float = parameter(0.05, "and of a turn between two scans", low=0.001, high=1.0)
    touch_memory_m: float = parameter(
        4.0, "an obstacle found by touch is kept for so many metres of travel", low=0.1, high=50.0, unit="m"
    )
