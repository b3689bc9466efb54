"""The `hslam` command.  Every subcommand imports what it needs when it runs, so that `--help` answers at once."""

import json
import sys
from collections import Counter
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Optional

import typer
from rich.console import Console
from rich.table import Table

from hslam_bringup import atlas_commands, errand_commands, import_commands
from hslam_bringup.linear_algebra import hold_to_one_thread
from hslam_bringup.robots import Robot
from hslam_types.errors import HslamError

app = typer.Typer(
    help="Hierarchical SLAM: explore a floor by sonar along the generalized Voronoi graph into an atlas of maps.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
bag_app = typer.Typer(help="Look into bags and repair damaged ones.", no_args_is_help=True)
app.add_typer(bag_app, name="bag")
app.add_typer(import_commands.app, name="import")
app.command()(errand_commands.navigate)
app.command()(errand_commands.localise)
app.command("map")(atlas_commands.map_bag)
app.command()(atlas_commands.info)
app.command()(atlas_commands.plot)
app.command()(atlas_commands.export)
app.command()(atlas_commands.merge)
console = Console()

World = Annotated[str, typer.Argument(help="wean_hall_6, small_world, a world YAML or a map_server YAML")]
BagPath = Annotated[Path, typer.Argument(help="a rosbag2 directory, or a .mcap or .db3 file")]
Settings = Annotated[
    Optional[list[str]], typer.Option("--set", help="NODE.PARAMETER=VALUE, e.g. ekf.accept_gate=9.0; repeatable")
]
Topics = Annotated[Optional[list[str]], typer.Option("--topic", help="only topics of this name or pattern; repeatable")]


class Landmarks(StrEnum):
    """What the edge-maps of a run are made of."""

    BOXES = "boxes"
    SCAN = "scan"


@app.command()
def explore(
    world: World,
    *,
    seed: Annotated[int, typer.Option(help="seed of all chance: noise, odometry bias, landmarks", min=0)] = 1,
    out: Annotated[
        Optional[Path], typer.Option(help="folder for bag, atlas, figures and report [runs/WORLD_SEED]")
    ] = None,
    robot: Annotated[
        Robot,
        typer.Option(help="sim: the Scout's ring of sonars; turtlebot: a lidar; scout: behind its serial line"),
    ] = Robot.SIM,
    landmarks: Annotated[
        Landmarks, typer.Option(help="boxes: hung on the walls; scan: what the lidar sees of the building itself")
    ] = Landmarks.BOXES,
    in_process: Annotated[
        bool, typer.Option("--in-process", help="one process instead of one per node: same atlas, faster")
    ] = False,
    settings: Settings = None,
    resume: Annotated[
        Optional[Path], typer.Option(help="folder of an earlier run of this floor and seed to go on with")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="replace an earlier run in --out")] = False,
    time_limit: Annotated[float, typer.Option(help="give up after so many simulated seconds", min=1.0)] = 14_400.0,
) -> None:
    """Explore a floor until nothing that is left can be reached, then draw and score what was learnt.

    Writes OUT/bag (rosbag2, MCAP), OUT/atlas.db, OUT/figures and OUT/report.json.
    Exit status 0 when no edge is left unexplored. An exploration that was interrupted or ran out of time is taken up by
    --resume FOLDER, into another --out: the robot stays where it is, finds out where that is, and goes on.
    """
    from hslam_bringup.errors import RunError
    from hslam_bringup.explore import explore_and_report
    from hslam_bringup.run_options import (
        BASES,
        LANDMARKS,
        LEVELS,
        RunOptions,
        landmark_settings,
        merged,
        parse_settings,
        robot_settings,
    )

    out = out or Path("runs") / f"{Path(world).stem}_{seed}"
    nodes = BASES[robot.value] + LEVELS + LANDMARKS[landmarks.value]
    chosen = merged(
        merged(robot_settings(robot.value), landmark_settings(landmarks.value)), parse_settings(settings or (), nodes)
    )
    options = RunOptions(world, seed, out, chosen, time_limit, robot.value, landmarks.value)
    if in_process and robot is Robot.SCOUT:
        raise RunError("--in-process drives the simulated base; the Scout has a serial line: leave one of the two out")
    try:
        explore_and_report(options, in_process=in_process, force=force, console=console, resume=resume)
    except KeyboardInterrupt:
        sys.stderr.write(f"hslam: interrupted; what was recorded until then is in {out}\n")
        raise typer.Exit(130) from None


@app.command()
def drive(
    robot: Annotated[Path, typer.Argument(help="the robot's YAML file: topics and parameters (docs/your_robot.md)")],
    *,
    out: Annotated[Path, typer.Option(help="folder for bag, atlas, drawing and logs")],
    landmarks: Annotated[
        Landmarks, typer.Option(help="scan: what the lidar sees of the building; boxes: what topic `landmarks` tells")
    ] = Landmarks.SCAN,
    force: Annotated[bool, typer.Option("--force", help="replace an earlier run in --out")] = False,
    time_limit: Annotated[float, typer.Option(help="give up after so many seconds", min=1.0)] = 14_400.0,
) -> None:
    """Explore with a real robot, whose own drivers run in this ROS domain, until nothing that is left can be reached.

    Ctrl-C stops the robot; what was learnt is kept. Example: hslam drive my_robot.yaml --out runs/building
    """
    from hslam_bringup.atlas_info import atlas_info
    from hslam_bringup.atlas_plot import plot
    from hslam_bringup.errand import atlas_state
    from hslam_bringup.live_run import LiveOptions, explore_live
    from hslam_bringup.robot_file import read_robot
    from hslam_bringup.run_options import prepare_output

    options = LiveOptions(read_robot(robot), landmarks.value, out, time_limit)
    prepare_output(out, force=force)
    try:
        explore_live(options, console)
    except KeyboardInterrupt:
        sys.stderr.write(f"hslam: interrupted, the robot is stopped; what was learnt until then is in {out}\n")
        raise typer.Exit(130) from None
    learnt = atlas_info(options.atlas)
    with atlas_state(options.atlas) as state:
        plot(state, out / "atlas.svg", is_chained=False)
    found = f"{learnt.nodes} nodes, {learnt.edges} edges, {learnt.unexplored} branches out of reach"
    console.print(found, highlight=False)
    console.print(f"bag, atlas and its drawing (atlas.svg) are in {out}")


@app.command()
def gvg(
    world: World,
    *,
    out: Annotated[Optional[Path], typer.Option(help="picture to draw (.png or .svg) [WORLD_gvg.png]")] = None,
) -> None:
    """Compute the true reduced GVG of a floor from its geometry, print its counts and draw it."""
    from hslam_bringup.errors import RunError
    from hslam_sim.truth import draw_true_gvg, true_gvg
    from hslam_sim.worlds import load_world

    floor = load_world(world)
    with console.status(f"computing the GVG of {floor.name}"):
        truth = true_gvg(floor)
        path = out or Path(f"{floor.name}_gvg.png")
        try:
            draw_true_gvg(floor, truth, path)
        except (OSError, ValueError) as error:
            raise RunError(f"cannot draw to {path}: {error}") from error
    degrees = Counter(node.degree for node in truth.nodes)
    core = sum(node.core for node in truth.nodes)
    cycles = len(truth.edges) - len(truth.nodes) + 1
    console.print(f"{len(truth.nodes)} nodes ({core} core), {len(truth.edges)} edges, {cycles} cycles")
    console.print("nodes by degree: " + ", ".join(f"{count} of {degree}" for degree, count in sorted(degrees.items())))
    console.print(f"drawn to {path}")


@app.command()
def record(
    path: Annotated[Path, typer.Argument(help="folder of the bag, new or empty")],
    *,
    topics: Topics = None,
    exclude: Annotated[
        Optional[list[str]],
        typer.Option(help="leave out topics of this name or pattern, besides /parameter_events; repeatable"),
    ] = None,
    split_mb: Annotated[Optional[int], typer.Option(help="begin a new file at this size; 0: never", min=0)] = None,
    split_s: Annotated[
        Optional[float], typer.Option(help="begin a new file after so many seconds; 0: never", min=0.0)
    ] = None,
) -> None:
    """Record topics of the running system to a rosbag2 directory (MCAP) until Ctrl-C."""
    from hslam_bags.commands import record as run

    given = {"split_mb": split_mb, "split_s": split_s}
    run(path, topics or (), exclude or (), {name: value for name, value in given.items() if value is not None})


@app.command()
def replay(
    bag: BagPath,
    *,
    topics: Topics = None,
    exclude: Annotated[
        Optional[list[str]],
        typer.Option("--exclude", help="leave out topics of this name or pattern, besides /rosout; repeatable"),
    ] = None,
    rate: Annotated[float, typer.Option(help="bag time by wall time", min=0.001)] = 1.0,
    start: Annotated[float, typer.Option(help="seconds from the first message to begin at", min=0.0)] = 0.0,
    max_gap: Annotated[
        float, typer.Option(help="seconds without a message that are waited for; a longer gap is passed over", min=0.1)
    ] = 60.0,
    paused: Annotated[bool, typer.Option("--paused", help="begin at rest; wake it by the service ~/resume")] = False,
    live: Annotated[
        str, typer.Option(help="nodes that run now, by commas: what they said in the bag is left out")
    ] = "",
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="as fast as the live nodes answer, instead of at a rate")
    ] = False,
) -> None:
    """Publish a bag's messages, with /clock."""
    from hslam_bags.commands import replay as run

    run(
        bag,
        topics or (),
        exclude or (),
        {"rate": rate, "start_s": start, "max_gap_s": max_gap, "paused": paused, "live": live, "lockstep": lockstep},
    )


@app.command()
def rebuild(
    bag: BagPath,
    *,
    out: Annotated[Path, typer.Option(help="folder for the atlas.db to write")],
    settings: Settings = None,
    force: Annotated[bool, typer.Option("--force", help="replace the atlas.db in --out")] = False,
) -> None:
    """Build a run's atlas again from its bag, with other parameters if wished; without any it is identical."""
    from hslam_bags.bag import Bag
    from hslam_bringup.bag_loop import rebuild_atlas
    from hslam_bringup.node_parameters import ALGORITHMS, check_settings
    from hslam_bringup.run_options import ATLAS_FILES, RunOptions, make_output, parse_settings

    options = RunOptions("", 0, out, parse_settings(settings or (), ("ekf", "atlas")))
    check_settings(options.settings, ALGORITHMS)
    with Bag(bag) as opened:
        make_output(out, ATLAS_FILES, force=force)
        with console.status(f"reading {bag}"):
            cycles = rebuild_atlas(opened, options)
    console.print(f"{cycles} cycles, the atlas is {options.atlas}")


@app.command()
def compare(
    a: Annotated[Path, typer.Argument(help="an atlas file or a run's folder")],
    b: Annotated[Path, typer.Argument(help="another")],
) -> None:
    """Compare two atlases; exit status 0 when their content is identical, 1 when it is not."""
    from hslam_bringup.compare import compare as run

    found = run(a, b)
    table = Table("", str(a), str(b))
    for name in ("nodes", "edges", "landmarks"):
        first, second = getattr(found, name)
        table.add_row(name, str(first), str(second))
    console.print(table)
    console.print(f"{found.edges_in_both} edges from the same drives, lengths {found.length_rms_m:.3f} m rms apart")
    console.print("identical" if found.identical else "not identical")
    raise typer.Exit(0 if found.identical else 1)


@bag_app.command("info")
def bag_info(bag: BagPath) -> None:
    """Tell what is in a bag, damaged or not."""
    from hslam_bags.commands import info

    found = info(bag, thorough=True)
    table = Table("topic", "type", "messages", title=f"{found.path}: {found.duration_s:.1f} s")
    for topic in found.topics:
        table.add_row(topic.name, topic.type_name, str(topic.message_count))
    console.print(table)
    for problem in found.problems:
        console.print(f"damaged: {problem}", highlight=False)
    raise typer.Exit(1 if found.problems else 0)


@bag_app.command("repair")
def bag_repair(
    bag: BagPath,
    target: Annotated[Optional[Path], typer.Argument(help="folder of the repaired bag [BAG_repaired]")] = None,
) -> None:
    """Copy what is readable of a damaged bag into a new, whole one; the damaged one is left as it is."""
    from hslam_bags.commands import repair

    found = repair(bag, target)
    console.print(json.dumps(found._asdict(), default=str, indent=2))


def main() -> None:
    """Run the command; an error the suite or the system knows (a full disk) is one line on stderr, exit status 1."""
    hold_to_one_thread()
    try:
        app()
    except (HslamError, OSError) as error:
        sys.stderr.write(f"hslam: {error}\n")
        sys.exit(1)
