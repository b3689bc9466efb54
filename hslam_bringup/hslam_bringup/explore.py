"""The main job: explore, then score and draw what was learnt."""

from pathlib import Path

from rich.console import Console

from hslam_bringup.errors import RunError
from hslam_bringup.in_process_run import run_in_process
from hslam_bringup.node_parameters import ALGORITHMS, NODES, check_settings
from hslam_bringup.progress import ExplorationProgress
from hslam_bringup.resumed import check_same_floor, take_up
from hslam_bringup.run_options import RunOptions, check_landmarks, prepare_output
from hslam_bringup.run_report import as_table, report_run
from hslam_bringup.separate_run import run_separately
from hslam_ros.private_domain import PrivateDomain, private_domain
from hslam_sim.worlds import load_world


def explore_and_report(
    options: RunOptions, *, in_process: bool, force: bool, console: Console, resume: Path | None = None
) -> None:
    """Run one exploration and leave bag, atlas, figures and report in ``options.out``.

    Raises HslamError where the run breaks or something is left unexplored; what was recorded stays readable. With
    ``force`` an earlier run in the folder is replaced; with ``resume`` another folder's run is gone on with.
    """
    # A slip of the pen costs no earlier run.
    check_settings(options.settings, ALGORITHMS if in_process else NODES)
    check_landmarks(options)
    load_world(options.world, landmark_seed=options.seed)
    if resume is not None:
        check_same_floor(resume, options)
    prepare_output(options.out, force=force)
    if resume is not None:
        options = take_up(resume, options)
    with ExplorationProgress(console) as progress:
        if in_process:
            end = run_in_process(options, progress.show)
        else:
            with private_domain() as domain:
                console.print(how_to_join(domain), soft_wrap=True)
                end = run_separately(options, domain, progress.show)
    with console.status("scoring and drawing"):
        fields = report_run(options, end, progress.wall_time_s)
    console.print(as_table(fields))
    console.print(f"bag, atlas, figures and report are in {options.out}")
    if fields["completed"] and (once := fields["driven_once"]):
        console.print(
            f"{once} of {fields['edges']} edges were driven once only: a junction passed unnoticed there is missing. "
            "--set atlas.drive_twice=true drives them again",
            soft_wrap=True,
        )
    if not end.finished:
        limit = f"{options.time_limit_s:.0f} simulated seconds"
        raise RunError(f"not finished after {limit}; what was learnt until then is in {options.out}")
    if left := fields["unexplored"]:
        raise RunError(f"not finished: branches that could not be reached: {left}; what was learnt is in {options.out}")


def how_to_join(domain: PrivateDomain) -> str:
    """Return the line that tells a person how to watch a run, which can be done on this machine alone."""
    number = domain.number
    return f"alone in ROS domain {number} of this machine; to join it: export ROS_DOMAIN_ID={number}"
