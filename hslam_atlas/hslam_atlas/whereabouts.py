"""Where the robot is in the graph: at a node, or on its way from one."""

from dataclasses import dataclass

from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.se2 import SE2


@dataclass(frozen=True, slots=True, eq=False)
class Here:
    """The node the robot stands at and how the last sight of it fits the stored one."""

    node: int
    keys: tuple[int, ...]
    """The node's branch key for each branch of the last view."""
    come: int | None
    """The key of the branch the robot came along, None if unknown."""
    traversal: int
    """The drive that led here, -1 without a map."""
    edge_in_node: UncertainPose | None
    """Frame of that drive's edge-map in the node's frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Underway:
    """The traversal under way."""

    node: int
    branch: int
    sequence: int
    departure_in_node: UncertainPose
    odom_in_node: SE2
    """The odom frame at departure, for the case that the robot gets lost."""
