"""Do different ways look alike on this floor?  Each new drive is compared with a few that it cannot be."""

from itertools import islice

from hslam_atlas.chain import chained
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.hypothesis import is_elsewhere
from hslam_atlas.retrace import compare
from hslam_atlas.state import AtlasState
from hslam_types.edge_map import EdgeMap

_TRIED = 4
"""Ways of a drive's length that are compared with it."""


def learn_look_alike_ways(state: AtlasState, start: EdgeEnd, edge_map: EdgeMap) -> None:
    """Compare a drive from ``start`` with edges of its length that begin elsewhere, as if they began where it does."""
    graph = state.graph
    elsewhere = (
        node
        for node, node_in_start in chained(graph, start.node).items()
        if is_elsewhere(node_in_start.inverse(), state.config)
    )
    ends = (
        (graph.edges[branch.edge], graph.edges[branch.edge].end_at(node, branch.key))
        for node in elsewhere
        for branch in graph.nodes[node].ordered()
        if branch.edge is not None
    )
    matches = (compare(state, edge, end, edge_map, edge.ends[end].frame_in_node) for edge, end in ends)
    for match in islice((match for match in matches if match is not None), _TRIED):
        state.look_alikes.count_way(match.evidence if match.agrees else -1.0)
