"""The report of one run, as written to ``report.json``."""

import dataclasses
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hslam_report.landmark_score import LandmarkScore
from hslam_report.score import GraphScore


@dataclasses.dataclass(frozen=True)
class RunFacts:
    """What the run itself knows, whatever the truth."""

    finished: bool
    """Whether the mission came to its end, not the time limit."""
    unexplored: int
    """Branches left unexplored at the end."""
    driven_once: int
    """Edges that were driven once only: a junction on them may have been passed unnoticed."""
    seed: int
    world: str
    path_length_m: float
    """Truly driven."""
    sim_time_s: float
    wall_time_s: float
    collisions: int
    peak_rss_mb: Mapping[str, float]
    """Peak resident memory of each node's process, by node name."""

    @property
    def completed(self) -> bool:
        """Whether it ended with no branch left unexplored."""
        return self.finished and not self.unexplored

    @property
    def real_time_factor(self) -> float:
        """Simulated per wall second; 0 if no time has passed."""
        return self.sim_time_s / self.wall_time_s if self.wall_time_s > 0.0 else 0.0


def report(facts: RunFacts, graph: GraphScore, landmarks: LandmarkScore) -> dict[str, Any]:
    """Return the report's fields in a fixed order; figures that do not exist (NaN) are None."""
    fields: dict[str, Any] = {
        "completed": facts.completed,
        "unexplored": facts.unexplored,
        "driven_once": facts.driven_once,
        "seed": facts.seed,
        "world": facts.world,
        **{field.name: getattr(graph, field.name) for field in dataclasses.fields(graph) if field.name != "matches"},
        "path_length_m": facts.path_length_m,
        "sim_time_s": facts.sim_time_s,
        "wall_time_s": facts.wall_time_s,
        "real_time_factor": facts.real_time_factor,
        "landmark_rmse_edge_m": landmarks.rmse_edge_m,
        "landmark_rmse_chained_m": landmarks.rmse_chained_m,
        "landmark_rmse_global_m": landmarks.rmse_global_m,
        "landmarks_mapped": landmarks.mapped,
        "landmarks_false": landmarks.false,
        "nees_mean": landmarks.nees_mean,
        "collisions": facts.collisions,
        "peak_rss_mb": dict(sorted(facts.peak_rss_mb.items())),
    }
    return {name: None if isinstance(v, float) and not math.isfinite(v) else v for name, v in fields.items()}


def write_report(path: Path, fields: Mapping[str, Any]) -> None:
    """Write a report as JSON, one field a line, replacing the file only once it is whole."""
    partial = path.with_name(path.name + ".part")
    partial.write_text(json.dumps(fields, indent=2) + "\n", encoding="utf-8")
    partial.replace(path)
