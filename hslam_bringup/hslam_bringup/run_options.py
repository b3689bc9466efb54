"""What a person asks of a run, and where its results go."""

import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory

from hslam_bringup.errors import RunError
from hslam_types.se2 import SE2
from hslam_types.yaml_text import YamlError, load_yaml

LEVELS = ("gvg", "ekf", "atlas")
BASES = {"sim": ("sim",), "turtlebot": ("sim",), "scout": ("scout_emulator", "scout")}
"""By robot: the nodes in place of the base."""
ROBOTS = {"turtlebot": "turtlebot.yaml"}
"""By robot: the file of this package that says by node how it differs from the simulated Scout."""
BOXES, SCANNED = "boxes", "scan"
LANDMARKS: Mapping[str, tuple[str, ...]] = {BOXES: (), SCANNED: ("scan_landmarks",)}
"""By kind of landmark, boxes on the walls or what the lidar's scans show: the nodes that look for them, beside a base
that sees boxes itself."""
SET_BY_THE_RUN = {
    "world", "seed", "landmark_seed", "start",
    "landmark_source", "lockstep", "lockstep_nodes", "mission", "port", "store",
}  # fmt: skip
"""Parameters that make a run what it is: `explore` has options for some, the others hold its parts together."""
ATLAS_FILES = ("atlas.db", "atlas.db-wal", "atlas.db-shm", "atlas.db-journal")
EARLIER_RUN = "resumed.json"
"""The file that names the run which one has taken up."""
_LEFT_BY_A_RUN = (*ATLAS_FILES, "bag", "figures", "report.json", "log", "scout.tty", EARLIER_RUN, "atlas.svg")


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
    """The robot: a key of `BASES`."""
    landmarks: str = BOXES
    """What the edge-maps are made of: a key of `LANDMARKS`."""
    start: SE2 | None = None
    """Where the robot stands (m, rad, in the world), if not at the world's start."""

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


def landmark_settings(landmarks: str) -> dict[str, dict[str, Any]]:
    """Return the parameters by node and name that go with a kind of landmark."""
    return {"sim": {"landmarks.look_every": 0}} if landmarks == SCANNED else {}


def check_landmarks(options: RunOptions) -> None:
    """Raise RunError where a robot without a lidar shall find its landmarks by one."""
    if options.landmarks == SCANNED and (
        options.robot == "scout" or not options.node_settings("sim").get("lidar.beams")
    ):
        raise RunError("--landmarks scan asks for a lidar: add --robot turtlebot or --set sim.lidar.beams=360")


def robot_settings(robot: str) -> dict[str, dict[str, Any]]:
    """Return the parameters by node and name that make the base a certain robot."""
    if robot not in ROBOTS:
        return {}
    path = Path(get_package_share_directory("hslam_bringup")) / "config" / ROBOTS[robot]
    settings: dict[str, dict[str, Any]] = load_yaml(path.read_text())
    return settings


def merged(first: Mapping[str, Mapping[str, Any]], over: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return settings by node and name, those of ``over`` in place of the first where both have one."""
    return {node: {**first.get(node, {}), **over.get(node, {})} for node in {**first, **over}}


def parse_settings(assignments: Sequence[str], nodes: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Parse ``node.parameter=value`` assignments (YAML values); raises RunError on anything else.

    ``nodes`` are those that take part; a setting of another one would change nothing and is an error too.
    """
    settings: dict[str, dict[str, Any]] = {}
    for assignment in assignments:
        target, equals, text = assignment.partition("=")
        node, dot, name = target.partition(".")
        if not (equals and dot and name) or node not in nodes:
            raise RunError(f"--set takes NODE.PARAMETER=VALUE with NODE one of {', '.join(nodes)}, not '{assignment}'")
        if name in SET_BY_THE_RUN:
            raise RunError(f"--set {assignment}: '{name}' is not a setting of a run (see --help for its options)")
        try:
            settings.setdefault(node, {})[name] = load_yaml(text)
        except YamlError as error:
            raise RunError(f"--set {target}: the value is not YAML ({error})") from error
    return settings


def prepare_output(out: Path, *, force: bool) -> None:
    """Make a folder for a run; what an earlier one left is removed if ``force`` is given, and nothing else is.

    Raises RunError where there is such and ``force`` is not given.
    """
    earlier = make_output(out, _LEFT_BY_A_RUN, force=force)
    try:
        for path in earlier:
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    except OSError as error:
        raise RunError(f"cannot write to {out}: {error.strerror}") from error


def make_output(out: Path, results: Sequence[str], *, force: bool) -> list[Path]:
    """Make a folder for results of these names and return the earlier ones in it, which are left as they are.

    Raises RunError where there are such and ``force`` is not given.
    """
    earlier = [out / name for name in results if os.path.lexists(out / name)]
    if earlier and not force:
        names = ", ".join(path.name for path in earlier)
        raise RunError(f"{out} already holds a run ({names}); choose another --out or give --force")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"cannot write to {out}: {error.strerror}") from error
    return earlier
