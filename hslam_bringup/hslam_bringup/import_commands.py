"""The subcommands of `hslam import`: data sets of others become bags."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

app = typer.Typer(help="Make a bag of a data set of others.", no_args_is_help=True)


@app.callback()
def _one_of_several() -> None:
    """Make a bag of a data set of others."""


@app.command()
def carmen(
    log: Annotated[Path, typer.Argument(help="a CARMEN log (.log, .clf), plain or packed (.gz, .bz2)")],
    *,
    out: Annotated[Path, typer.Option(help="folder of the bag, new or empty")],
    range_max: Annotated[
        float, typer.Option(help="readings from here on (m) say that nothing answered", min=1.0, max=1000.0)
    ] = 80.0,
    as_json: Annotated[bool, typer.Option("--json", help="print what was in it as JSON, and nothing else")] = False,
) -> None:
    """Write the odometry and scans of a CARMEN log to a bag: /odom, /scan, /tf, /tf_static.

    Example: hslam import carmen intel.clf.bz2 --out bags/intel
    """
    from hslam_bringup.carmen_import import import_carmen

    size = log.stat().st_size if log.exists() else None
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(f"reading {log.name}", total=size)
        found = import_carmen(log, out, range_max, lambda read: progress.update(task, completed=read))
    if as_json:
        sys.stdout.write(json.dumps(found.fields) + "\n")
        return
    console = Console(soft_wrap=True, highlight=False)
    console.print(f"{out}: {found.scans} scans, {found.seconds:.0f} s, {found.driven_m:.0f} m by odometry")
    if found.clock_steps_back:
        console.print(
            f"its clock steps back {found.clock_steps_back} times: the order of the lines holds, not their times"
        )
    if found.left_out:
        console.print("left out: " + ", ".join(f"{count} {name}" for name, count in sorted(found.left_out.items())))
