"""Scores and draws a run from what it left on disk."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from rich.table import Table

from hslam_atlas.explore import driven_once, unexplored
from hslam_atlas.store import AtlasStore
from hslam_bringup.resumed import whole_log
from hslam_bringup.run_evidence import explored_graph, placed_maps
from hslam_bringup.run_options import SCANNED, RunOptions
from hslam_report.landmark_score import score_landmarks
from hslam_report.path_figures import length_m
from hslam_report.run_figures import write_figures
from hslam_report.run_report import RunFacts, report, write_report
from hslam_report.score import score_graph
from hslam_ros.stamps import NS_PER_S
from hslam_sim.truth import true_gvg
from hslam_sim.worlds import load_world


@dataclass(frozen=True)
class RunEnd:
    """How a run ended, as far as its bag and atlas do not tell."""

    finished: bool
    """The mission came to its end, not the time limit."""
    peak_rss_mb: Mapping[str, float]
    """By node."""


def report_run(options: RunOptions, end: RunEnd, wall_time_s: float) -> dict[str, Any]:
    """Write figures and report.json for the run in ``options.out`` and return the report's fields.

    Raises BagError or StoreError where the run's files cannot be read.
    """
    world = load_world(options.world, landmark_seed=options.seed)
    if options.landmarks == SCANNED:
        world = replace(world, landmarks=world.corners)
    log = whole_log(options.out)
    with AtlasStore.reading(options.atlas) as store:
        graph, _ = store.load()
        explored = explored_graph(graph, log)
        maps = placed_maps(store, graph, explored, log)
    facts = RunFacts(
        finished=end.finished,
        unexplored=unexplored(graph),
        driven_once=driven_once(graph),
        seed=options.seed,
        world=options.world,
        path_length_m=length_m(log.driven.in_map),
        sim_time_s=log.end_ns / NS_PER_S,
        wall_time_s=wall_time_s,
        collisions=log.contacts,
        peak_rss_mb=end.peak_rss_mb,
    )
    fields = report(facts, score_graph(explored, true_gvg(world)), score_landmarks(maps, world.landmarks))
    write_report(options.report, fields)  # first: figures are what a full disk has no room for
    write_figures(options.figures, world, log.driven, explored, maps, log.step_of_event)
    return fields


def as_table(fields: Mapping[str, Any]) -> Table:
    """Return a report for a terminal."""
    table = Table("what", "figure", title=f"{fields['world']}, seed {fields['seed']}")
    for name, value in fields.items():
        if name not in ("world", "seed"):
            table.add_row(name, f"{value:.3f}" if isinstance(value, float) else json.dumps(value))
    return table
