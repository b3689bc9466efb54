"""Landmarks that two edge-maps share: those about a node, which every edge that meets it sees.

Both maps lie almost in place there, whatever the floor looks like from afar: the node's frame says how their frames
lie to each other, and a filter on what is left of that offset (eq. 7) finds the pairs.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from hslam_atlas.alignment import align
from hslam_atlas.config import AtlasConfig
from hslam_atlas.edge_maps import EdgeMaps
from hslam_atlas.graph import AtlasGraph, Node
from hslam_atlas.map_match import near, part

_WITHIN_M = 12.0
"""Farther from their node than this, hardly a landmark is seen from two edges."""
_FEWEST = 3
"""Fewer pairs than this may come about by chance."""


class SharedLandmark(NamedTuple):
    """One landmark as two edge-maps have it."""

    edge: int
    landmark: int
    """Its index in the edge's map."""
    other_edge: int
    other_landmark: int


def shared_about(node: Node, graph: AtlasGraph, maps: EdgeMaps, config: AtlasConfig) -> list[SharedLandmark]:
    """Return what the maps of any two edges that meet at a node share about it."""
    ends = [
        (edge_id, graph.edges[edge_id].end_at(node.id, branch.key))
        for branch in node.ordered()
        if (edge_id := branch.edge) is not None
    ]
    shared: list[SharedLandmark] = []
    for (first, first_end), (second, second_end) in combinations(ends, 2):
        if first == second:
            continue  # an edge from a node back to itself: its map holds each landmark once
        a, b = maps.seen_from(first, first_end), maps.seen_from(second, second_end)
        near_a, near_b = near(a, _WITHIN_M), near(b, _WITHIN_M)
        a_in_node = graph.edges[first].ends[first_end].frame_in_node
        b_in_a = a_in_node.inverse() @ graph.edges[second].ends[second_end].frame_in_node
        floor = np.diag([config.pair_noise_m**2, config.pair_noise_m**2, config.heading_floor**2])
        pairs = align(
            part(a, near_a),
            part(b, near_b),
            b_in_a.pose,
            b_in_a.inflated(config.chain_inflation).covariance + floor,
            density=1.0,  # the background is of no concern: where the maps lie is known
            pair_noise_m=config.pair_noise_m,
            terminal_noise_m=0.0,
            gate=config.pair_gate,
        ).pairs
        if len(pairs) >= _FEWEST:
            shared += [SharedLandmark(first, int(near_a[i]), second, int(near_b[j])) for i, j in pairs]
    return shared
