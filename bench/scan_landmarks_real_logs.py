"""Landmarks by scans of real robots: how many a look has, how many the next look has again, and how well they agree.

python bench/scan_landmarks_real_logs.py ../shared/lidar_logs
"""

import bz2
import math
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from hslam_landmarks.config import ScanLandmarksConfig
from hslam_landmarks.scan_landmarks import look
from hslam_types.se2 import SE2
from hslam_types.sensing import LandmarkSighting, LandmarkView, RangeScan

LOGS = {"intel": math.radians(1.0), "fr079": math.radians(0.5)}
"""By log: the angle between two beams."""
CONFIG = ScanLandmarksConfig(range_std_m=0.02)
ODOMETRY_TURN_STD = 0.01
"""What the odometry's heading is off from one look to the next (rad)."""


def looks(path: Path, step: float) -> Iterator[tuple[SE2, LandmarkView]]:
    """Yield the odometry and the look of every third scan of the log's first 3,000."""
    with bz2.open(path, "rt") as log:
        scans = (line.split() for line in log if line.startswith("FLASER"))
        for number, words in zip(range(3000), scans, strict=False):
            if number % 3 == 0:
                end = 2 + int(words[1])
                ranges = np.array(words[2:end], dtype=np.float64)
                scan = RangeScan(number, SE2(), -0.5 * math.pi, step, 0.1, 30.0, ranges)
                yield SE2(*map(float, words[end : end + 3])), look(scan, CONFIG)


def chi(before: LandmarkSighting, moved: SE2, now: LandmarkSighting) -> float:
    """Return the squared distance of two sightings over their variances, by the odometry between them."""
    x, y = before.range_m * math.cos(before.bearing), before.range_m * math.sin(before.bearing)
    x, y = moved.inverse().apply(x, y)
    turn = math.remainder(math.atan2(y, x) - now.bearing, math.tau)
    across = before.bearing_std**2 + now.bearing_std**2 + ODOMETRY_TURN_STD**2
    return (math.hypot(x, y) - now.range_m) ** 2 / (before.range_std_m**2 + now.range_std_m**2) + turn**2 / across


def main() -> None:
    """Print one line a log."""
    for name, step in LOGS.items():
        all_looks = list(looks(Path(sys.argv[1]) / f"{name}.clf.bz2", step))
        nearest = []
        for (base, before), (base_now, now) in pairwise(all_looks):
            moved = base.to(base_now)
            if math.hypot(moved.x, moved.y) < 0.3 and abs(moved.theta) < 0.2:
                inside = [s for s in before.sightings if abs(s.bearing) < 1.2 and s.range_m < 6.0]
                nearest += [min((chi(s, moved, other) for other in now.sightings), default=math.inf) for s in inside]
        again = np.array([value for value in nearest if value < 25.0])
        print(
            f"{name}: {np.mean([len(view.sightings) for _, view in all_looks]):.1f} a look, "
            f"{len(again) / len(nearest):.2f} seen again, NIS by dimension {again.mean() / 2.0:.2f}"
        )


if __name__ == "__main__":
    main()
