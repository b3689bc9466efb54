"""An atlas as a networkx graph: for GraphML, and for whoever computes on it."""

import networkx as nx

from hslam_atlas.graph import AtlasGraph
from hslam_atlas.picture import Picture


def networkx_graph(graph: AtlasGraph, pictures: list[Picture]) -> "nx.MultiGraph[int]":
    """Return nodes and edges with what the atlas knows of them, lengths in metres, bearings in radians.

    ``pictures``: one a connected part; nodes of a part have places in its own frame, named by ``part``.
    """
    network: nx.MultiGraph[int] = nx.MultiGraph()
    for part, picture in enumerate(pictures):
        for node_id, pose in sorted(picture.nodes.items()):
            node = graph.nodes[node_id]
            network.add_node(
                node_id,
                part=part,
                x=pose.x,
                y=pose.y,
                theta=pose.theta,
                kind=node.kind.name.lower(),
                clearance_m=node.clearance_m,
                visits=len(node.visits),
                unexplored=sum(branch.unexplored for branch in node.branches.values()),
            )
    for edge in graph.edges.values():
        (first, second), branches = (end.node for end in edge.ends), [end.branch for end in edge.ends]
        bearings = [graph.nodes[end.node].branches[end.branch].bearing for end in edge.ends]
        network.add_edge(
            first,
            second,
            key=edge.id,
            length_m=edge.path_length_m,
            distance_m=edge.terminal_x,
            first=first,
            branch_at_first=branches[0],
            branch_at_second=branches[1],
            bearing_at_first=bearings[0],
            bearing_at_second=bearings[1],
            drives=len(edge.traversals),
        )
    return network
