"""The two ways along an edge from where the robot is on it, or beside it, to where it shall go."""

from collections.abc import Callable
from typing import NamedTuple

from hslam_atlas.graph import AtlasGraph
from hslam_atlas.missions.destination import Destination, OnEdge, ends_of
from hslam_types.se2 import SE2, wrap


class BothWays(NamedTuple):
    """What each costs, in metres."""

    onward_m: float
    """By the edge's other end."""
    back_m: float
    """By the end the edge is seen from."""
    heading_in_odom: float
    """The direction of the first (rad): that of the edge as a whole, whose path may bend."""


def both_ways(
    graph: AtlasGraph,
    edge_id: int,
    end: int,
    base_in_node: SE2,
    odom_turn: float,
    destination: Destination,
    from_node_m: Callable[[int], float],
) -> BothWays:
    """Weigh both ways from a pose (m, rad) in the frame of the node at an edge's ``end``.

    ``odom_turn``: from that frame to odom (rad); ``from_node_m``: what the rest of the way costs from a node.
    """
    edge = graph.edges[edge_id]
    edge_in_node = edge.ends[end].frame_in_node.pose
    x, _ = edge_in_node.inverse().apply(base_in_node.x, base_in_node.y)
    share = min(max(x / edge.terminal_x, 0.0), 1.0) if edge.terminal_x > 0.0 else 0.0
    onward_m = (1.0 - share) * edge.path_length_m + from_node_m(edge.ends[1 - end].node)
    back_m = share * edge.path_length_m + from_node_m(edge.ends[end].node)
    if isinstance(destination, OnEdge) and destination.edge == edge_id:
        there = ends_of(graph, destination)[end].in_node
        ahead_m = edge_in_node.inverse().apply(*there)[0] - x
        onward_m = ahead_m if ahead_m >= 0.0 else onward_m
        back_m = -ahead_m if ahead_m <= 0.0 else back_m
    return BothWays(onward_m, back_m, wrap(edge_in_node.theta + odom_turn))
