"""The `hslam` command."""

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from hslam_types.errors import HslamError

app = typer.Typer(
    help="Hierarchical SLAM: explore a floor by sonar along the generalized Voronoi graph, into an atlas of maps.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
console = Console()


@app.command()
def explore(
    world: Annotated[str, typer.Argument(help="wean_hall_6, small_world, a world YAML or a map_server YAML")],
    seed: Annotated[int, typer.Option(help="seed of all chance: noise, odometry bias, landmarks", min=0)] = 1,
    out: Annotated[
        Path | None, typer.Option(help="folder for bag, atlas, figures and report [runs/WORLD_SEED]")
    ] = None,
    in_process: Annotated[
        bool, typer.Option("--in-process", help="one process instead of one per node: same atlas, faster")
    ] = False,
    settings: Annotated[
        list[str], typer.Option("--set", help="NODE.PARAMETER=VALUE, e.g. ekf.accept_gate=9.0; repeatable")
    ] = [],  # noqa: B006
    force: Annotated[bool, typer.Option("--force", help="replace an earlier run in --out")] = False,
    time_limit: Annotated[float, typer.Option(help="give up after so many simulated seconds", min=1.0)] = 14_400.0,
) -> None:
    """Explore a floor until no edge is left unexplored, then draw and score what was learnt.

    Writes OUT/bag (rosbag2, MCAP), OUT/atlas.db, OUT/figures and OUT/report.json.
    Exit status 0 when the exploration completed.
    """
    from hslam_bringup.errors import RunError
    from hslam_bringup.explore import explore_and_report  # heavy imports only where they are needed
    from hslam_bringup.run_options import RunOptions, parse_settings, prepare_output

    out = out or Path("runs") / f"{Path(world).stem}_{seed}"
    options = RunOptions(world, seed, out, parse_settings(settings), time_limit)
    prepare_output(out, force=force)
    try:
        fields = explore_and_report(options, in_process=in_process, console=console)
    except KeyboardInterrupt:
        sys.stderr.write(f"hslam: interrupted; what was recorded until then is in {out}\n")
        raise typer.Exit(130) from None
    if not fields["completed"]:
        raise RunError(
            f"not finished after {time_limit:.0f} s of simulated time; what was learnt until then is in {out}"
        )


@app.command()
def gvg(
    world: Annotated[str, typer.Argument(help="wean_hall_6, small_world, a world YAML or a map_server YAML")],
    out: Annotated[Path | None, typer.Option(help="picture to draw (.png or .svg) [WORLD_gvg.png]")] = None,
) -> None:
    """Compute the true reduced GVG of a floor from its geometry, print its counts and draw it."""
    from hslam_sim.truth import draw_true_gvg, true_gvg
    from hslam_sim.worlds import load_world

    floor = load_world(world)
    with console.status(f"computing the GVG of {floor.name}"):
        truth = true_gvg(floor)
        path = out or Path(f"{floor.name}_gvg.png")
        draw_true_gvg(floor, truth, path)
    console.print(truth.summary(), f"drawn to {path}", sep="\n")


def main() -> None:
    """Run the command; an error the suite knows is one line on stderr and exit status 1."""
    try:
        app()
    except HslamError as error:
        sys.stderr.write(f"hslam: {error}\n")
        sys.exit(1)
