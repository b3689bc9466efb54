"""The subcommands that look into an atlas or hand it on: info, plot, export, merge."""

import json
import sys
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Optional

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

Atlas = Annotated[Path, typer.Argument(help="an atlas file, as `hslam explore` leaves it in OUT/atlas.db")]
Json = Annotated[bool, typer.Option("--json", help="print the result as JSON, and nothing else, on stdout")]


class Format(StrEnum):
    """What an atlas can be written as."""

    GEOJSON = "geojson"
    GRAPHML = "graphml"
    MAP = "map"
    TUM = "tum"


def info(atlas: Atlas, *, as_json: Json = False) -> None:
    """Tell what is in an atlas: nodes, edges, parts, open questions, lengths.

    Example: hslam info runs/small_world_1/atlas.db --json
    """
    from hslam_bringup.atlas_info import atlas_info

    _print(atlas_info(atlas).fields, as_json=as_json)


def plot(
    atlas: Atlas,
    *,
    out: Annotated[Path, typer.Option(help="drawing to write: .pdf, .svg or .png")],
    chained: Annotated[
        bool, typer.Option("--chained", help="lay edges end to end, cycles not closed, instead of by least squares")
    ] = False,
) -> None:
    """Draw what was learnt, by itself: nodes with their numbers, edges, landmarks, 95 % ellipses.

    Example: hslam plot runs/small_world_1/atlas.db --out small_world.pdf
    """
    from hslam_bringup.atlas_plot import plot as run
    from hslam_bringup.errand import atlas_state

    with atlas_state(atlas) as state, Console(stderr=True).status("drawing"):
        said = run(state, out, is_chained=chained)
    Console(soft_wrap=True).print(f"{out}: {said}", highlight=False)


def export(
    atlas: Atlas,
    *,
    to: Annotated[
        Format,
        typer.Option(help="geojson: a route graph for Nav2; graphml; map: map_server YAML + PGM; tum: the way driven"),
    ],
    out: Annotated[Path, typer.Option(help="file to write; for map the YAML, its PGM comes beside it")],
    bag: Annotated[
        Optional[Path],
        typer.Option(help="the run's bag, which holds the way driven: map and tum need it, geojson bends edges by it"),
    ] = None,
    resolution: Annotated[float, typer.Option(help="of the map: metres a cell", min=0.005, max=1.0)] = 0.05,
    as_json: Json = False,
) -> None:
    """Write an atlas for others, laid out by least squares in the frame of its oldest node.

    Example: hslam export runs/small_world_1/atlas.db --to map --bag runs/small_world_1/bag --out small_world.yaml
    """
    from hslam_bringup.atlas_export import export as run
    from hslam_bringup.errand import atlas_state
    from hslam_bringup.errors import RunError

    if to is Format.MAP and out.suffix != ".yaml":
        raise RunError(f"--to map writes a YAML file and a PGM beside it: --out must end in .yaml, not '{out.name}'")
    try:
        with atlas_state(atlas) as state:
            done = _watched("reading the bag", lambda show: run(state, to.value, out, bag, resolution, show))
    except OSError as error:
        raise RunError(f"cannot write {out}: {error.strerror or error}") from error
    _print({"file": str(done.path), "said": done.said}, as_json=as_json)


def map_bag(
    bag: Annotated[Path, typer.Argument(help="a bag with odometry and scans: a folder, an .mcap or a .db3 file")],
    *,
    out: Annotated[Path, typer.Option(help="folder for the atlas, its picture, the path and a bag of what was found")],
    odom: Annotated[str, typer.Option(help="topic of the odometry (nav_msgs/Odometry)")] = "/odom",
    scan: Annotated[str, typer.Option(help="topic of the scans (sensor_msgs/LaserScan)")] = "/scan",
    settings: Annotated[
        Optional[list[str]],
        typer.Option("--set", help="NODE.PARAMETER=VALUE with NODE one of gvg, scan_landmarks, ekf, atlas; repeatable"),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="replace what an earlier run left in --out")] = False,
    as_json: Json = False,
) -> None:
    """Build an atlas from the bag of a robot that somebody drove about: it finds the nodes and edges that were passed.

    The robot needs odometry and a planar scanner, and nothing on the walls: landmarks are corners and poles.

    Example: hslam map bags/intel --out maps/intel
    """
    from hslam_bags.bag import Bag
    from hslam_bringup.atlas_export import export as write
    from hslam_bringup.atlas_plot import plot as draw
    from hslam_bringup.errand import atlas_state
    from hslam_bringup.errors import RunError
    from hslam_bringup.map_run import WATCHED, MapTopics
    from hslam_bringup.map_run import map_bag as run
    from hslam_bringup.node_parameters import ALGORITHMS, check_settings
    from hslam_bringup.run_options import RunOptions, merged, parse_settings, prepare_output

    nodes = ("gvg", "scan_landmarks", "ekf", "atlas")
    options = RunOptions("", 0, out, parse_settings(settings or (), nodes))
    if fixed := sorted(WATCHED["gvg"].keys() & options.node_settings("gvg").keys()):
        raise RunError(f"--set gvg.{fixed[0]}: here the GVG level watches scans, and drives nothing")
    check_settings(merged(options.settings, WATCHED), ALGORITHMS)
    with Bag(bag) as opened:
        prepare_output(out, force=force)
        done = _watched("mapping", lambda show: run(opened, MapTopics(odom, scan), options, show))
    if done.edges:
        with atlas_state(options.atlas) as state:
            draw(state, out / "atlas.svg", is_chained=False)
            _watched("placing the path", lambda show: write(state, "tum", out / "path.tum", options.bag, 0.05, show))
    _print(done.fields, as_json=as_json)


def merge(
    a: Annotated[Path, typer.Argument(help="an atlas file; its ids stay")],
    b: Annotated[Path, typer.Argument(help="another of the same floor, by another session or robot")],
    *,
    out: Annotated[Path, typer.Option(help="atlas file to write, a new one")],
    as_json: Json = False,
) -> None:
    """Join two atlases of one floor where they overlap, wherever each of them began.

    Example: hslam merge monday/atlas.db tuesday/atlas.db --out both.db

    Exit status 1, a line that says why, and no file where it is not beyond doubt how they belong together.
    """
    from hslam_bringup.joined_atlas import joined

    with Console(stderr=True).status("matching edges"):
        done = joined(a, b, out)
    fields = {"nodes_in_common": done.nodes, "edges_in_common": done.edges, "evidence": done.evidence}
    _print({"file": str(out), **fields}, as_json=as_json)


def _watched(what: str, run: Callable[[Callable[[float], None]], Any]) -> Any:
    """Run with a progress bar on stderr."""
    columns = (TextColumn("{task.description}"), BarColumn(bar_width=20), TaskProgressColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(what, total=1.0)
        try:
            return run(lambda share: progress.update(task, completed=share))
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
        table.add_row(name, f"{value:.3f}" if isinstance(value, float) else str(value))
    Console().print(table)
