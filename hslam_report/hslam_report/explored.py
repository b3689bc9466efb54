"""The explored graph as plain values: what the scores and figures need of an atlas, with the truth of each visit."""

import math
from dataclasses import dataclass

from hslam_types.gvg_events import NodeKind, NodeView
from hslam_types.se2 import SE2, Array


@dataclass(frozen=True, slots=True)
class Visit:
    """One arrival or departure at a node, and where that truly was (m, in map)."""

    sequence: int
    """Of the event."""
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class ExploredNode:
    """One node of the atlas."""

    id: int
    kind: NodeKind
    degree: int
    """Its branches, the unexplored ones included."""
    clearance_m: float
    visits: tuple[Visit, ...]
    """At least one, in order of time."""


@dataclass(frozen=True, slots=True)
class ExploredEdge:
    """One edge of the atlas; branches count from 0 in the node's counter-clockwise order."""

    u: int
    v: int
    branch_u: int
    branch_v: int
    length_m: float
    """Driven from u to v."""


@dataclass(frozen=True, eq=False)
class ExploredGraph:
    """The atlas's graph; edges name nodes by id."""

    nodes: tuple[ExploredNode, ...]
    edges: tuple[ExploredEdge, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PlacedEdgeMap:
    """One stored edge-map, with where its frame truly was and where the atlas puts its landmarks."""

    name: str
    terminal_x: float
    """The estimated distance between its meet points (m)."""
    landmarks: Array
    """In the edge frame, n x 2 (m)."""
    covariance: Array
    """(2 + 2n) x (2 + 2n), the terminal first."""
    frame_in_map: SE2
    """The true frame: origin at the true first meet point, x through the true terminal one."""
    chained: Array
    """The landmarks in the picture of the whole along shortest chains of edges, n x 2 (m): cycles do not close."""
    optimised: Array
    """The same in the picture by least squares.  Each picture has a frame of its own."""
    closed: bool = False
    """Whether it ends where it began: then its frame has no true direction, and is turned as in the chained picture."""


def true_meet_point(base_in_map: SE2, base_in_odom: SE2, node: NodeView) -> tuple[float, float]:
    """Return where a node truly was (m, in map), as seen from the true and the odometric pose of one event."""
    node_in_base = base_in_odom.inverse().apply(node.x_in_odom, node.y_in_odom)
    return base_in_map.apply(*node_in_base)


def edge_frame_in_map(origin: tuple[float, float], terminal: tuple[float, float]) -> SE2:
    """Return the pose in map of the edge frame from one true meet point through another."""
    return SE2(*origin, math.atan2(terminal[1] - origin[1], terminal[0] - origin[0]))
