"""Real robots' logs through the whole chain, scored by the relations of the Freiburg SLAM benchmark.

python bench/mapped_logs.py ../shared/lidar_logs

Every NAME.clf.bz2 of the folder is imported and mapped with the defaults; NAME.relations (R. Kuemmerle et al., "On
measuring the accuracy of SLAM algorithms", 2009) says where pairs of scans truly lie to each other: two times, then the
second pose in the first as x, y, z, roll, pitch, yaw. Relations of less than 5 s are of one passage, others of loops.
A relation counts where both poses are on a drive that has become part of an edge.
"""

import argparse
import math
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from hslam_types.se2 import SE2, Array

NEAR_S = 5.0
"""Relations of less than this are of one passage."""
APART_S = 0.06
"""A pose this near in time is a scan's own."""
COLUMNS = (
    "log", "part", "relations", "scored", "mean m", "mean deg", "median m", "median deg", "times real time",
)  # fmt: skip


def errors(path: Array, relations: Array) -> Array:
    """Return of each relation that can be scored the time between its poses, and the errors (s, m, rad), n x 3.

    ``path``: n x 8, as a TUM file; ``relations``: n x 8.
    """
    path = path[np.argsort(path[:, 0], kind="stable")]
    found = []
    for begin, end, x, y, _, _, _, yaw in relations:
        first, second = (_pose(path, at) for at in (begin, end))
        if first is not None and second is not None:
            off = SE2(x, y, yaw).inverse() @ first.to(second)
            found.append((abs(end - begin), math.hypot(off.x, off.y), abs(off.theta)))
    return np.array(found).reshape(-1, 3)


def _pose(path: Array, at_s: float) -> SE2 | None:
    index = int(np.argmin(np.abs(path[:, 0] - at_s)))
    if abs(path[index, 0] - at_s) > APART_S:
        return None
    return SE2(path[index, 1], path[index, 2], 2.0 * math.atan2(path[index, 6], path[index, 7]))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("logs", type=Path, help="folder of the logs and their relations")
    parser.add_argument("--out", type=Path, help="folder to keep bags and maps in")
    options = parser.parse_args()
    out = options.out or Path(tempfile.mkdtemp(prefix="hslam_mapped_logs_"))
    table = Table(*COLUMNS, title=f"maps in {out}")
    console = Console(width=160)
    for log in sorted(options.logs.glob("*.clf.bz2")):
        name = log.name.removesuffix(".clf.bz2")
        bag, mapped = out / f"{name}_bag", out / f"{name}_map"
        subprocess.run(["hslam", "import", "carmen", str(log), "--out", str(bag)], check=True)
        began = time.monotonic()
        subprocess.run(["hslam", "map", str(bag), "--out", str(mapped)], check=True)
        took_s = time.monotonic() - began
        path = np.loadtxt(mapped / "path.tum")
        rows = [line.split() for line in (options.logs / f"{name}.relations").read_text().splitlines()]
        relations = np.array([row for row in rows if len(row) == 8], dtype=np.float64)
        scored, apart_s = errors(path, relations), np.abs(relations[:, 1] - relations[:, 0])
        speed = (path[:, 0].max() - path[:, 0].min()) / took_s
        parts = {
            "all": (np.isfinite(scored[:, 0]), len(relations)),
            "one passage": (scored[:, 0] < NEAR_S, int((apart_s < NEAR_S).sum())),
            "loops": (scored[:, 0] >= NEAR_S, int((apart_s >= NEAR_S).sum())),
        }
        for part, (which, count) in parts.items():
            metres, degrees = scored[which, 1], np.degrees(scored[which, 2])
            figures = (metres.mean(), degrees.mean(), np.median(metres), np.median(degrees))
            table.add_row(
                name, part, str(count), str(int(which.sum())), *(f"{figure:.3f}" for figure in figures), f"{speed:.0f}"
            )
    console.print(table)


if __name__ == "__main__":
    main()
