"""Breaks explorations off at random times and goes on with each; what matters is that the graph is the whole one.

hslam-env python bench/resumed_runs.py wean_hall_6 --restarts 20
"""

import argparse
import json
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from hslam_bringup.fleet import executable


def explore(world: str, out: Path, *more: str) -> dict[str, Any]:
    """Explore in one process; return the report."""
    command = [str(executable("hslam_bringup", "hslam")), "explore", world, "--in-process", "--out", str(out), *more]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    report = out / "report.json"
    if not report.exists():
        raise SystemExit(f"{out}: {(done.stderr.strip().splitlines() or ['no message'])[-1]}")
    fields: dict[str, Any] = json.loads(report.read_text())
    return fields


def main() -> None:
    """Parse the command line and print the table; exit status 1 where a resumed run did not become the whole graph."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("world")
    parser.add_argument("--restarts", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1, help="of the restarts' times; run k has world seed k")
    parser.add_argument("--from-s", type=float, default=100.0, help="earliest break, simulated")
    parser.add_argument("--to-s", type=float, default=2200.0, help="latest break, simulated")
    parser.add_argument("--robot", default="sim")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    broken_off_s = np.random.default_rng(options.seed).uniform(options.from_s, options.to_s, options.restarts)
    kept = Path(tempfile.mkdtemp(prefix="hslam_resumed_"))
    with Progress(console=Console(stderr=True)) as progress, ThreadPoolExecutor(options.jobs) as pool:

        def both(k: int) -> tuple[dict[str, Any], dict[str, Any]]:
            same = ("--seed", str(k + 1), "--robot", options.robot)
            first, second = kept / f"{k + 1}_first", kept / f"{k + 1}_second"
            return (
                explore(options.world, first, *same, "--time-limit", f"{broken_off_s[k]:.1f}"),
                explore(options.world, second, *same, "--resume", str(first)),
            )

        runs = list(progress.track(pool.map(both, range(options.restarts)), options.restarts, description="exploring"))
    table = Table("seed", "broken off s", "nodes then", "nodes", "edges", "completed", "isomorphic", "false", "metres")
    for k, (then, whole) in enumerate(runs):
        row = (then["nodes"], whole["nodes"], whole["edges"], whole["completed"], whole["isomorphic"])
        more = (whole["loop_closures_false"], round(whole["path_length_m"]))
        table.add_row(str(k + 1), f"{broken_off_s[k]:.0f}", *map(str, row + more))
    Console(width=120).print(table)
    good = sum(whole["completed"] and whole["isomorphic"] for _, whole in runs)
    print(f"{good} of {len(runs)} completed and isomorphic; runs in {kept}")
    sys.exit(good < len(runs))


if __name__ == "__main__":
    main()
