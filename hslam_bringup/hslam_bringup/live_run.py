"""A real robot explores: the levels beside its own drivers, by the wall clock, to the end of the mission."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from hslam_bringup.errors import RunError
from hslam_bringup.fleet import Fleet, NodeProcess
from hslam_bringup.live_onlooker import LiveOnlooker
from hslam_bringup.progress import ExplorationProgress
from hslam_bringup.robot_file import RobotFile
from hslam_bringup.run_options import LANDMARKS
from hslam_gvg.level import SCAN

_LOOK_S = 0.25
_SILENT_S = 10.0
"""Without a cycle for so long the person is told what is awaited."""


@dataclass(frozen=True)
class LiveOptions:
    """What a person asks of an exploration by a real robot."""

    robot: RobotFile
    landmarks: str
    """What the edge-maps are made of: a key of `run_options.LANDMARKS`; boxes are whatever `landmarks` tells."""
    out: Path
    time_limit_s: float
    """Wall time after which an unfinished exploration is given up."""

    @property
    def atlas(self) -> Path:
        """The atlas file; one that is there is gone on with."""
        return self.out / "atlas.db"


def explore_live(options: LiveOptions, console: Console) -> None:
    """Explore until the mission ends; raises RunError where it does not, NodeDiedError where a node ends early.

    However it ends, the robot is stopped first and the bag is closed last.
    """
    nodes = _nodes(options)
    fleet = Fleet(options.out / "log")
    onlooker = LiveOnlooker()
    try:
        for node in nodes:
            fleet.start(node)
        with ExplorationProgress(console) as progress:
            _watch(fleet, onlooker, options, progress, console)
    finally:
        onlooker.close()
        fleet.stop([node.name for node in reversed(nodes)])


def _nodes(options: LiveOptions) -> list[NodeProcess]:
    """Return the nodes to start, the recorder first; the one that drives is last, and thus stopped first."""
    robot = options.robot
    recorder = {"path": str(options.out / "bag"), "require": "gvg/events"}
    own: list[tuple[str, str, dict[str, Any]]] = [
        ("atlas", "hslam_atlas", {"store": str(options.atlas), "mission": "explore"}),
        ("ekf", "hslam_ekf", {"landmark_source": ""}),
        *((name, "hslam_landmarks", {}) for name in LANDMARKS[options.landmarks]),
        ("gvg", "hslam_gvg", {}),
    ]
    levels = [
        NodeProcess(name, package, f"{name}_node", {"lockstep": False} | chosen | robot.of(name), topics=robot.topics)
        for name, package, chosen in own
    ]
    return [NodeProcess("recorder", "hslam_bags", "record_node", recorder), *levels]


def _watch(
    fleet: Fleet, onlooker: LiveOnlooker, options: LiveOptions, progress: ExplorationProgress, console: Console
) -> None:
    """Follow the run until the mission's end."""
    began_s, told = time.monotonic(), False
    while True:
        time.sleep(_LOOK_S)
        fleet.ended("atlas")
        now = onlooker.look()
        waited_s = time.monotonic() - began_s
        if now is not None:
            progress.show(now)
        elif waited_s > _SILENT_S and not told:
            told = True
            console.print(awaited(options.robot), soft_wrap=True)
        if onlooker.finished:
            return
        if waited_s > options.time_limit_s:
            raise RunError(f"not finished after {options.time_limit_s:.0f} s; what was learnt is in {options.out}")


def awaited(robot: RobotFile) -> str:
    """Return what to look at when a robot says nothing."""
    ranges = "scan" if robot.of("gvg").get("source") == SCAN else "sonar"
    names = ", ".join(robot.topics.get(name, name) for name in ("odom", ranges))
    return f"nothing heard yet: do the robot's drivers publish {names} in this ROS domain (ros2 topic hz)?"
