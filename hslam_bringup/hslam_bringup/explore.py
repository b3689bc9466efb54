"""The main job: explore, then score and draw what was learnt."""

from rich.console import Console

from hslam_bringup.errors import RunError
from hslam_bringup.in_process_run import run_in_process
from hslam_bringup.node_parameters import ALGORITHMS, NODES, check_settings
from hslam_bringup.progress import ExplorationProgress
from hslam_bringup.run_options import RunOptions, prepare_output
from hslam_bringup.run_report import as_table, report_run
from hslam_bringup.separate_run import run_separately
from hslam_sim.worlds import load_world


def explore_and_report(options: RunOptions, *, in_process: bool, force: bool, console: Console) -> None:
    """Run one exploration and leave bag, atlas, figures and report in ``options.out``.

    Raises HslamError where the run breaks or something is left unexplored; what was recorded stays readable. With
    ``force`` an earlier run in the folder is replaced.
    """
    # A slip of the pen costs no earlier run.
    check_settings(options.settings, ALGORITHMS if in_process else NODES)
    load_world(options.world, landmark_seed=options.seed)
    prepare_output(options.out, force=force)
    run = run_in_process if in_process else run_separately
    with ExplorationProgress(console) as progress:
        end = run(options, progress.show)
    with console.status("scoring and drawing"):
        fields = report_run(options, end, progress.wall_time_s)
    console.print(as_table(fields))
    console.print(f"bag, atlas, figures and report are in {options.out}")
    if not end.finished:
        limit = f"{options.time_limit_s:.0f} simulated seconds"
        raise RunError(f"not finished after {limit}; what was learnt until then is in {options.out}")
    if left := fields["unexplored"]:
        raise RunError(f"not finished: branches that could not be reached: {left}; what was learnt is in {options.out}")
