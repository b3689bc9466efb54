"""What a person asks of a run, and where its results go."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from hslam_bringup.errors import RunError

NODES = ("sim", "gvg", "ekf", "atlas", "scout", "scout_emulator")
"""The nodes of a run whose parameters `--set` reaches."""


@dataclass(frozen=True)
class RunOptions:
    """One exploration: the same options and seed give the same atlas, in one process or many."""

    world: str
    seed: int
    out: Path
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Parameters by node and name, over the defaults."""
    time_limit_s: float = 14_400.0
    """Simulated time after which an unfinished exploration is given up."""
    robot: str = "sim"
    """The base: "sim" directly, or "scout" through the emulated serial line."""

    @property
    def bag(self) -> Path:
        """The rosbag2 directory."""
        return self.out / "bag"

    @property
    def atlas(self) -> Path:
        """The atlas file."""
        return self.out / "atlas.db"

    @property
    def figures(self) -> Path:
        """The folder of the figures."""
        return self.out / "figures"

    @property
    def report(self) -> Path:
        """The report."""
        return self.out / "report.json"

    def node_settings(self, node: str) -> dict[str, Any]:
        """Return the parameters that were set for one node."""
        return dict(self.settings.get(node, {}))


def parse_settings(assignments: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Parse ``node.parameter=value`` assignments (YAML values); raises RunError on anything else."""
    settings: dict[str, dict[str, Any]] = {}
    for assignment in assignments:
        target, equals, text = assignment.partition("=")
        node, dot, name = target.partition(".")
        if not (equals and dot and name) or node not in NODES:
            raise RunError(f"--set takes NODE.PARAMETER=VALUE with NODE one of {', '.join(NODES)}, not '{assignment}'")
        try:
            settings.setdefault(node, {})[name] = yaml.safe_load(text)
        except yaml.YAMLError as error:
            raise RunError(f"--set {assignment}: the value is not YAML ({error.__class__.__name__})") from error
    return settings


def prepare_output(out: Path, *, force: bool) -> None:
    """Make the run's folder; raises RunError where it holds an earlier run and ``force`` is not given."""
    earlier = [name for name in ("bag", "atlas.db", "report.json") if (out / name).exists()]
    if earlier and not force:
        raise RunError(f"{out} already holds a run ({', '.join(earlier)}); choose another --out or give --force")
    try:
        out.mkdir(parents=True, exist_ok=True)
        for path in sorted(out.rglob("*"), reverse=True) if earlier else []:
            path.rmdir() if path.is_dir() else path.unlink()
    except OSError as error:
        raise RunError(f"cannot write to {out}: {error.strerror}") from error
