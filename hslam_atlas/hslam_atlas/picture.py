"""A global picture of the atlas, composed when asked for and for display only."""

from hslam_atlas.chain import chained
from hslam_atlas.graph import AtlasGraph, Edge
from hslam_types.se2 import SE2


def node_poses(graph: AtlasGraph) -> dict[int, SE2]:
    """Return every node's frame in ``map``: the frame of the oldest node; parts not connected to it are left out."""
    if not graph.nodes:
        return {}
    return {node: pose.pose for node, pose in sorted(chained(graph, min(graph.nodes)).items())}


def edge_frame_in_map(edge: Edge, poses: dict[int, SE2]) -> SE2:
    """Return an edge's frame in ``map``, given its first node's pose there."""
    end = edge.ends[0]
    return poses[end.node] @ end.frame_in_node.pose
