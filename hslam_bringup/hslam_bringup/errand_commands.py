"""The subcommands that use an atlas: navigate, localise."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Optional

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from hslam_bringup.robots import Robot

Atlas = Annotated[Path, typer.Argument(help="an atlas file, as `hslam explore` leaves it in OUT/atlas.db")]
World = Annotated[str, typer.Option(help="the world the atlas is of: a shipped name, a world YAML, a map_server YAML")]
WorldSeed = Annotated[int, typer.Option(help="the seed it was explored with: it says where the landmarks are", min=0)]
Seed = Annotated[int, typer.Option(help="seed of the places drawn and of the robot's noise", min=0)]
Base = Annotated[Robot, typer.Option(help="sim: the Scout's ring of sonars; turtlebot: a lidar")]
Json = Annotated[bool, typer.Option("--json", help="print the result as JSON, and nothing else, on stdout")]
Settings = Annotated[
    Optional[list[str]], typer.Option("--set", help="NODE.PARAMETER=VALUE, e.g. ekf.accept_gate=9.0; repeatable")
]

Show = Callable[[int, str], None]


def navigate(
    atlas: Atlas,
    *,
    world: World,
    world_seed: WorldSeed = 1,
    goals: Annotated[int, typer.Option(help="how many random places to go to", min=1)] = 10,
    seed: Seed = 7,
    robot: Base = Robot.SIM,
    as_json: Json = False,
    settings: Settings = None,
) -> None:
    """Send a simulated robot, started where the atlas was, to random places of a known floor; score where it stops.

    Example: hslam navigate runs/small_world_1/atlas.db --world small_world --goals 5

    Exit status 0 when every goal was reached.
    """
    from hslam_bringup.navigate_run import navigate as run

    errand = _errand(atlas, world, world_seed, robot, settings)
    found = _watched("going", goals, lambda show: run(errand, goals, seed, show))
    _print(found.fields, as_json=as_json)
    raise typer.Exit(0 if found.reached == found.goals else 1)


def localise(
    atlas: Atlas,
    *,
    world: World,
    world_seed: WorldSeed = 1,
    starts: Annotated[int, typer.Option(help="how many random places to wake up at", min=1)] = 10,
    seed: Seed = 7,
    robot: Base = Robot.SIM,
    as_json: Json = False,
    settings: Settings = None,
) -> None:
    """Wake a simulated robot up at random places of a known floor until it knows where it is; score what it says.

    Example: hslam localise runs/small_world_1/atlas.db --world small_world --starts 5

    Exit status 0 when no place was a wrong one; those in doubt are neither right nor wrong.
    """
    from hslam_bringup.localise_run import localise as run

    errand = _errand(atlas, world, world_seed, robot, settings)
    found = _watched("waking up", starts, lambda show: run(errand, starts, seed, show))
    _print(found.fields, as_json=as_json)
    raise typer.Exit(1 if found.wrong else 0)


def _errand(atlas: Path, world: str, world_seed: int, robot: Robot, settings: list[str] | None) -> Any:
    from hslam_bringup.errand import errand
    from hslam_bringup.errors import RunError
    from hslam_bringup.run_options import parse_settings

    if robot is Robot.SCOUT:
        raise RunError("errands drive the simulated base in one process; the Scout has a serial line: use --robot sim")
    return errand(atlas, world, world_seed, robot.value, parse_settings(settings or (), ("sim", "gvg", "ekf")))


def _watched(what: str, total: int, run: Callable[[Show], Any]) -> Any:
    """Run with a progress bar on stderr."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        MofNCompleteColumn(),
        TextColumn("{task.fields[now]}"),
    )
    with Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True)) as progress:
        task = progress.add_task(what, total=total, now="")
        try:
            return run(lambda done, now: progress.update(task, completed=done, now=now))
        except KeyboardInterrupt:
            progress.stop()
            sys.stderr.write("hslam: interrupted\n")
            raise typer.Exit(130) from None


def _print(fields: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        sys.stdout.write(json.dumps(fields) + "\n")
        return
    table = Table("what", "figure")
    for name, value in fields.items():
        table.add_row(name, f"{value:.3f}" if isinstance(value, float) else json.dumps(value))
    Console().print(table)
