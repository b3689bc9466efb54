"""What is looked for in a scan, and what is asked of it before it is called a landmark."""

import math
from dataclasses import dataclass

from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2


@dataclass(frozen=True)
class ScannerConfig(Configuration):
    """Where the scanner is mounted."""

    scan_forward_m: float = parameter(
        0.0, "the scanner's place before base_link's origin", low=-5.0, high=5.0, unit="m"
    )
    scan_left_m: float = parameter(0.0, "the scanner's place to its left", low=-5.0, high=5.0, unit="m")
    scan_yaw: float = parameter(0.0, "direction of the scanner's x axis in base_link", low=-6.3, high=6.3, unit="rad")

    @property
    def scanner_in_base(self) -> SE2:
        """Pose of the scanner in base_link."""
        return SE2(self.scan_forward_m, self.scan_left_m, self.scan_yaw)


@dataclass(frozen=True)
class ScanLandmarksConfig(Configuration):
    """Parameters of the extraction; defaults hold for scanners of 0.25 to 1 degree and 5 to 30 mm."""

    look_every: int = parameter(3, "scans from one look to the next", low=1, high=1000)
    range_max_m: float = parameter(10.0, "farthest landmark told", low=0.5, high=100.0, unit="m")
    range_std_m: float = parameter(0.015, "standard deviation of a beam's range", low=0.001, high=0.5, unit="m")
    split_m: float = parameter(
        0.05,
        "returns farther than this from the line through a stretch's ends divide it",
        low=0.005,
        high=1.0,
        unit="m",
    )
    least_returns: int = parameter(4, "returns that a face of a wall must have", low=3, high=1000)
    least_length_m: float = parameter(0.15, "length that a face must have", low=0.02, high=10.0, unit="m")
    least_turn: float = parameter(
        math.radians(40.0), "angle between two faces from which their crossing is a corner", low=0.1, high=1.5,
        unit="rad",
    )  # fmt: skip
    least_depth_m: float = parameter(
        0.12, "how far behind a face the light must go on, beside its end, for that to be one", low=0.02, high=5.0,
        unit="m",
    )  # fmt: skip
    pole_width_m: float = parameter(
        0.3, "widest thing standing free that is a pole; 0: no poles", low=0.0, high=1.0, unit="m"
    )
    least_gap_m: float = parameter(
        0.2, "of two landmarks nearer than this only the better known is told", low=0.0, high=2.0, unit="m"
    )
    worst_std_m: float = parameter(
        0.2, "a landmark less well known than this in any direction is not told", low=0.01, high=1.0, unit="m"
    )
    still_std_m: float = parameter(
        0.015, "error that stays from look to look (walls are not straight), added to each landmark's", low=0.0,
        high=0.5, unit="m",
    )  # fmt: skip
