"""A robot as its owner describes it in one YAML file: the topics it speaks on and the parameters of the nodes."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hslam_bringup.errors import RunError
from hslam_bringup.node_parameters import NODES, check_settings
from hslam_bringup.run_options import SET_BY_THE_RUN
from hslam_types.errors import ConfigurationError
from hslam_types.yaml_text import YamlError, load_yaml

TOPICS = ("odom", "scan", "sonar", "landmarks", "cmd_vel")
"""What the nodes hear of a robot and say to it."""
LEVELS = ("gvg", "scan_landmarks", "ekf", "atlas")
"""The nodes whose parameters may be set."""


@dataclass(frozen=True)
class RobotFile:
    """What the file says."""

    topics: Mapping[str, str]
    """By the name of `TOPICS`: the robot's."""
    settings: Mapping[str, Mapping[str, Any]]
    """By node and parameter, over the defaults."""

    def of(self, node: str) -> dict[str, Any]:
        """Return the parameters of a node."""
        return dict(self.settings.get(node, {}))


def read_robot(path: Path) -> RobotFile:
    """Read a robot's file; raises RunError, naming file and key, where it says what no node understands."""
    try:
        content = load_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}") from error
    except (YamlError, UnicodeDecodeError) as error:
        raise RunError(f"{path} is not YAML: {error}") from error
    if not isinstance(content, dict) or not all(isinstance(part, dict) for part in content.values()):
        raise RunError(f"{path} must hold 'topics' and nodes ({', '.join(LEVELS)}), each with its own keys below it")
    topics = content.pop("topics", {})
    for name, there in topics.items():
        if name not in TOPICS or not isinstance(there, str):
            raise RunError(f"{path}: topics takes names of topics for {', '.join(TOPICS)}, not '{name}: {there}'")
    for node, settings in content.items():
        if node not in LEVELS:
            raise RunError(f"{path}: '{node}' is none of topics, {', '.join(LEVELS)}")
        if taken := SET_BY_THE_RUN & settings.keys():
            raise RunError(f"{path}: {node}.{min(taken)} is chosen by the command, not by the robot")
    try:
        check_settings(content, NODES)
    except ConfigurationError as error:
        raise RunError(f"{path}: {error}") from error
    return RobotFile(topics, content)
