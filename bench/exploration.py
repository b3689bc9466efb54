"""Explores worlds with many seeds, each run a process of its own, and prints a table of their reports.

python bench/exploration.py wean_hall_6 --seeds 1-10
python bench/exploration.py MAPS/*.yaml --seeds 1-5 --robot turtlebot      # map_server maps of others, by lidar
python bench/exploration.py small_world --seeds 1-3 --separate      # separate processes and DDS, one run at a time
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from hslam_bringup.fleet import executable

COLUMNS = {
    "completed": "done",
    "unexplored": "left",
    "isomorphic": "iso",
    "nodes": "nodes",
    "true_core_nodes": "true",
    "node_precision": "node prec",
    "node_recall": "rec",
    "edge_precision": "edge prec",
    "edge_recall": "rec",
    "loop_closures_false": "false",
    "loop_closures_missed": "missed",
    "collisions": "contacts",
    "path_length_m": "metres",
    "landmark_rmse_edge_m": "rmse edge",
    "landmark_rmse_chained_m": "chained",
    "landmark_rmse_global_m": "global",
    "nees_mean": "nees",
    "real_time_factor": "x real time",
}


def explore(world: str, seed: int, out: Path, arguments: list[str]) -> dict[str, Any]:
    """Run one exploration; return its report, or how it failed."""
    command = [str(executable("hslam_bringup", "hslam")), "explore", world, "--seed", str(seed), "--out", str(out)]
    done = subprocess.run([*command, *arguments], capture_output=True, text=True, check=False)
    report = out / "report.json"
    if report.exists():
        fields: dict[str, Any] = json.loads(report.read_text())
        return fields
    return {"failed": (done.stderr.strip().splitlines() or ["no message"])[-1]}


def cell(value: Any) -> str:
    """Return a figure as it stands in the table."""
    if isinstance(value, bool):
        return "yes" if value else "NO"
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def main() -> None:
    """Parse the command line and print the table; exit status 1 when a run failed or touched a wall."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="+")
    parser.add_argument("--seeds", default="1-10", help="one seed or a range, such as 1-10")
    parser.add_argument("--robot", default="sim", help="as for hslam explore, such as turtlebot")
    parser.add_argument("--landmarks", default="boxes", help="as for hslam explore: boxes on the walls, or scan")
    parser.add_argument("--separate", action="store_true", help="separate processes instead of one, one run at a time")
    parser.add_argument("--jobs", type=int, default=2, help="runs at a time (in one process each)")
    parser.add_argument("--time-limit", type=float, default=14_400.0, help="simulated seconds a run may take")
    parser.add_argument("--out", type=Path, help="folder to keep the runs in")
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    jobs = [(world, seed) for world in options.worlds for seed in range(int(first), int(last or first) + 1)]
    kept = options.out or Path(tempfile.mkdtemp(prefix="hslam_exploration_"))
    arguments = ["--force", "--time-limit", str(options.time_limit), "--robot", options.robot]
    arguments += ["--landmarks", options.landmarks]
    arguments += [] if options.separate else ["--in-process"]
    console = Console(width=200)
    with (
        Progress(console=Console(stderr=True)) as progress,
        ThreadPoolExecutor(1 if options.separate else options.jobs) as pool,
    ):
        task = progress.add_task("exploring", total=len(jobs))

        def one(job: tuple[str, int]) -> dict[str, Any]:
            world, seed = job
            report = explore(world, seed, kept / f"{Path(world).stem}_{seed}", arguments)
            progress.advance(task)
            return report

        reports = list(pool.map(one, jobs))
    table = Table("world", "seed", *COLUMNS.values(), title=f"runs in {kept}")
    for (world, seed), report in zip(jobs, reports, strict=True):
        figures = [report["failed"]] if "failed" in report else [cell(report[name]) for name in COLUMNS]
        table.add_row(Path(world).stem, str(seed), *figures)
    console.print(table)
    whole = [report for report in reports if "failed" not in report]
    good = sum(report["completed"] and report["isomorphic"] for report in whole)
    console.print(f"{good} of {len(reports)} completed and isomorphic", highlight=False)
    if whole:
        speed = statistics.median(report["real_time_factor"] for report in whole)
        console.print(f"median {speed:.1f} times real time", highlight=False)
    sys.exit(len(whole) < len(reports) or any(report["collisions"] for report in whole))


if __name__ == "__main__":
    main()
