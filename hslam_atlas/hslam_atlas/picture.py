"""A global picture of the atlas, composed when asked for and for display only."""

from hslam_atlas.chain import chained
from hslam_atlas.graph import AtlasGraph, Edge
from hslam_atlas.mapper import Mapper
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


def traversal_in_map(mapper: Mapper, poses: dict[int, SE2]) -> tuple[int, SE2] | None:
    """Return the traversal whose edge frame the robot is tracked in, and that frame in ``map``; None if not known.

    Until its arrival that is the departure frame, from then on the frame of its edge-map, as at the EKF level.
    """
    here, underway = mapper.here, mapper.underway
    if underway is not None:
        node, traversal, frame_in_node = underway.node, underway.sequence, underway.departure_in_node
    elif here is not None and here.edge_in_node is not None:
        node, traversal, frame_in_node = here.node, here.traversal, here.edge_in_node
    else:
        return None
    return (traversal, poses[node] @ frame_in_node.pose) if node in poses else None
