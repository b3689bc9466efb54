"""A run that goes on where an earlier one was broken off: with its atlas, from where its robot stood."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from hslam_atlas.numbering import last_number
from hslam_atlas.store import AtlasStore
from hslam_bringup.errors import RunError
from hslam_bringup.run_evidence import RunLog, read_log
from hslam_bringup.run_options import EARLIER_RUN, RunOptions
from hslam_report.path_figures import DrivenPath
from hslam_types.se2 import SE2


def check_same_floor(earlier: Path, options: RunOptions) -> None:
    """Raise RunError where a run cannot go on with an earlier one, as far as that has left a report."""
    if earlier.resolve() == options.out.resolve():
        raise RunError(f"--resume {earlier} is --out itself: choose another --out")
    if options.robot == "scout":
        raise RunError("--resume needs a base put where it stood: the Scout's emulator begins at the floor's start")
    report = earlier / "report.json"
    if not report.exists():
        return
    fields = json.loads(report.read_text(encoding="utf-8"))
    if (fields["world"], fields["seed"]) != (options.world, options.seed):
        raise RunError(f"{earlier} explored {fields['world']} with --seed {fields['seed']}: resume it with these")


def take_up(earlier: Path, options: RunOptions) -> RunOptions:
    """Copy an earlier run's atlas into a new run's folder; return that run, its robot where the earlier one's stood.

    Raises BagError, StoreError or RunError where the earlier run's files cannot be read.
    """
    log = whole_log(earlier)
    with AtlasStore.reading(earlier / options.atlas.name) as store:
        graph, _ = store.load()
        store.save_as(options.atlas)
    note = {"run": str(earlier.resolve()), "first_number": last_number(graph) + 1}
    (options.out / EARLIER_RUN).write_text(json.dumps(note), encoding="utf-8")
    return replace(options, start=SE2(*log.driven.in_map[-1].tolist()))


def whole_log(run: Path) -> RunLog:
    """Return what a run recorded, after what the one that it resumed had; raises BagError, RunError."""
    log = read_log(run / "bag")
    note = run / EARLIER_RUN
    if not note.exists():
        return log
    fields = json.loads(note.read_text(encoding="utf-8"))
    return _joined(whole_log(Path(fields["run"])), log, fields["first_number"])


def _joined(earlier: RunLog, later: RunLog, first_number: int) -> RunLog:
    """Return two logs as one; the later events count on from ``first_number``, as the atlas counts them."""
    steps = len(earlier.driven.in_map)
    driven = DrivenPath(
        np.vstack((earlier.driven.in_odom, later.driven.in_odom)),
        np.vstack((earlier.driven.in_map, later.driven.in_map)),
    )
    # What was announced after the atlas was last saved is not in it, and its numbers were given anew.
    known = {number: event for number, event in earlier.events.items() if number < first_number}
    events = {number + first_number: event for number, event in later.events.items()}
    step_of = {number + first_number: steps + step for number, step in later.step_of_event.items()}
    rows = {number: earlier.step_of_event[number] for number in known}
    return RunLog(driven, later.end_ns, known | events, rows | step_of, earlier.contacts + later.contacts)
