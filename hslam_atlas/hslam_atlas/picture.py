"""A global picture of the atlas, composed when asked for; nothing is decided by it."""

from dataclasses import dataclass

from hslam_atlas.chain import chained
from hslam_atlas.edge_maps import EdgeMaps
from hslam_atlas.graph import AtlasGraph, Edge
from hslam_types.se2 import SE2, Array


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Nodes, edges and landmarks of one connected part of an atlas, in the frame of one of its nodes (m, rad)."""

    nodes: dict[int, SE2]
    """By id; the one that gives the frame first."""
    edge_frames: dict[int, SE2]
    """By edge: the frame of its map."""
    landmarks: dict[int, Array]
    """By edge: the landmarks of its map, n x 2."""
    node_covariances: dict[int, Array]
    """By node, 3 x 3, of its pose."""


def node_poses(graph: AtlasGraph) -> dict[int, SE2]:
    """Return every node's frame in ``map``: the frame of the oldest node; parts not connected to it are left out."""
    if not graph.nodes:
        return {}
    return {node: pose.pose for node, pose in sorted(chained(graph, min(graph.nodes)).items())}


def composed(graph: AtlasGraph, maps: EdgeMaps, anchor: int) -> Picture:
    """Return the picture along shortest chains from node ``anchor``: cycles do not close in it."""
    chain = chained(graph, anchor)
    poses = {node: pose.pose for node, pose in chain.items()}
    frames = {edge.id: edge_frame_in_map(edge, poses) for edge in graph.edges.values() if edge.ends[0].node in poses}
    landmarks = {edge: frame.apply_all(maps.get(edge).landmarks) for edge, frame in frames.items()}
    return Picture(poses, frames, landmarks, {node: pose.covariance for node, pose in chain.items()})


def parts(graph: AtlasGraph) -> list[list[int]]:
    """Return the ids of the nodes of each connected part (by edges or links), ascending, the largest part first."""
    left, found = set(graph.nodes), []
    while left:
        part = sorted(chained(graph, min(left)))
        left.difference_update(part)
        found.append(part)
    return sorted(found, key=lambda part: (-len(part), part[0]))


def edge_frame_in_map(edge: Edge, poses: dict[int, SE2]) -> SE2:
    """Return an edge's frame in ``map``, given its first node's pose there."""
    end = edge.ends[0]
    return poses[end.node] @ end.frame_in_node.pose
