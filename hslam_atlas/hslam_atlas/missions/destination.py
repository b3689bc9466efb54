"""Where a robot can be sent: a node, or a point in the frame of an edge, however the person said it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hslam_atlas.edge_maps import EdgeMaps
from hslam_atlas.errors import AtlasError
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.picture import edge_frame_in_map, node_poses
from hslam_types.se2 import SE2

_ABOUT_M = 3.0
"""What is within this of a point is about it."""


class DestinationError(AtlasError):
    """There is no such place in the atlas; the text names it."""


@dataclass(frozen=True, slots=True)
class AtNode:
    """A node, arrived at."""

    node: int


@dataclass(frozen=True, slots=True)
class OnEdge:
    """A point in an edge's frame (m): ``distance`` along its x axis from its first node, ``offset`` to the left."""

    edge: int
    distance: float
    offset: float


Destination = AtNode | OnEdge


class FromEnd(NamedTuple):
    """A point on an edge as seen from one of its nodes."""

    node: int
    branch: int
    in_node: tuple[float, float]
    """The point in the node's frame (m)."""
    along_m: float
    """About how far along the edge."""


def check(destination: Destination, graph: AtlasGraph) -> Destination:
    """Return a destination that exists; raises DestinationError for one that does not."""
    if isinstance(destination, AtNode):
        if destination.node not in graph.nodes:
            raise DestinationError(f"the atlas has no node {destination.node}")
    elif destination.edge not in graph.edges:
        raise DestinationError(f"the atlas has no edge {destination.edge}")
    elif not np.isfinite([destination.distance, destination.offset]).all():
        raise DestinationError("a point on an edge needs a finite distance and offset")
    return destination


def from_map(graph: AtlasGraph, maps: EdgeMaps, x: float, y: float) -> OnEdge:
    """Return a point of the composed picture (m, `map`) in the frame of the edge it lies beside.

    Raises DestinationError where there is no edge in the part of the atlas that `map` shows.
    """
    poses = node_poses(graph)
    frames = {e.id: edge_frame_in_map(e, poses) for e in graph.edges.values() if e.ends[0].node in poses}
    return beside(graph, maps, frames, x, y)


def beside(graph: AtlasGraph, maps: EdgeMaps, frames: Mapping[int, SE2], x: float, y: float) -> OnEdge:
    """Return a point in the frame of the edge it lies beside, ``frames`` being those of the edges where it is given.

    Raises DestinationError where no edge is.
    """
    if not (math.isfinite(x) and math.isfinite(y)):
        raise DestinationError("a point needs finite coordinates")
    ranked = _ranked(graph, maps, frames, x, y)
    if not ranked:
        raise DestinationError(f"the atlas knows nothing about ({x:.1f}, {y:.1f})")
    return ranked[0]


def otherwise(graph: AtlasGraph, maps: EdgeMaps, point: OnEdge) -> list[OnEdge]:
    """Return the same point in the frames of the edges that meet its own, the likelier ones first.

    About a node several edges have seen the same walls.
    """
    edge = graph.edges[point.edge]
    frames: dict[int, SE2] = {}
    for here, origin in ((edge.ends[0], SE2()), (edge.ends[1], SE2(edge.terminal_x, 0.0, math.pi))):
        node_in_edge = origin @ here.frame_in_node.pose.inverse()
        for branch in graph.nodes[here.node].ordered():
            if branch.edge is None or branch.edge == point.edge or branch.edge in frames:
                continue
            other = graph.edges[branch.edge]
            end = other.end_at(here.node, branch.key)
            other_origin = SE2() if end == 0 else SE2(other.terminal_x, 0.0, math.pi)
            frames[other.id] = node_in_edge @ other.ends[end].frame_in_node.pose @ other_origin.inverse()
    return _ranked(graph, maps, frames, point.distance, point.offset)


def _ranked(graph: AtlasGraph, maps: EdgeMaps, frames: Mapping[int, SE2], x: float, y: float) -> list[OnEdge]:
    """Return a point in the frames of the edges that have seen what is about it, those first that have seen it longest.

    Neighbours look round corners, but not as long as who drives past.
    """
    found: list[tuple[float, OnEdge]] = []
    for edge_id, frame in sorted(frames.items()):
        px, py = frame.inverse().apply(x, y)
        edge_map, drives = maps.get(edge_id), len(graph.edges[edge_id].traversals)
        away = np.hypot(edge_map.landmarks[:, 0] - px, edge_map.landmarks[:, 1] - py)
        seen = float(np.array(edge_map.sightings)[away < _ABOUT_M].sum()) / drives
        if seen:
            found.append((seen, OnEdge(edge_id, px, py)))
    return [point for _, point in sorted(found, key=lambda item: -item[0])]


def ends_of(graph: AtlasGraph, point: OnEdge) -> tuple[FromEnd, FromEnd]:
    """Return a point on an edge as seen from either end's node."""
    edge = graph.edges[point.edge]
    far_in_edge = SE2(edge.terminal_x, 0.0, math.pi)
    seen = []
    for end in (0, 1):
        here = edge.ends[end]
        x, y = (point.distance, point.offset) if end == 0 else far_in_edge.inverse().apply(point.distance, point.offset)
        share = min(max(x / edge.terminal_x, 0.0), 1.0) if edge.terminal_x > 0.0 else 0.0
        in_node = here.frame_in_node.pose.apply(x, y)
        seen.append(FromEnd(here.node, here.branch, in_node, share * edge.path_length_m))
    return seen[0], seen[1]
