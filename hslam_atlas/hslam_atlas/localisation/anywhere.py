"""Which places of the whole atlas a drive fits, nothing being known of where it began."""

import math

import numpy as np

from hslam_atlas.graph import AtlasGraph, EdgeEnd
from hslam_atlas.hypothesis import Sight, align_branches, view_evidence
from hslam_atlas.localisation.place import Place
from hslam_atlas.map_match import match_constellations
from hslam_atlas.retrace import compare, far_sight_in_node
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2, wrap

_HEADING_STD = math.radians(4.0)
"""Of a branch between two visits."""
_STARTS = tuple(math.radians(degrees) for degrees in (0.0, -6.0, 6.0))
"""Headings the alignment of a constellation is started from, about that of the branch come along."""


def along_an_edge(state: AtlasState, edge_map: EdgeMap, sight: Sight) -> list[Place]:
    """Return the far end of every edge whose map matches a drive from node to node."""
    found = []
    prior = -math.log(max(2 * len(state.graph.edges), 1))
    for edge in state.graph.edges.values():
        for end in (0, 1):
            match = compare(state, edge, end, edge_map, edge.ends[end].frame_in_node)
            if match is not None and match.agrees:
                sight_in_node = far_sight_in_node(edge, end, edge_map, match)
                evidence = prior + state.look_alikes.capped(match.evidence)
                found.append(arrived(state, edge.ends[1 - end].node, sight, sight_in_node, edge_map, evidence))
    return found


def about_a_node(state: AtlasState, edge_map: EdgeMap, sight: Sight) -> list[Place]:
    """Return every node, and branch of it, that the end of a drive from somewhere on an edge looks like."""
    back = sight.edge_map
    if sight.come_along < 0 or back is None:
        return []
    found = []
    ends = [(edge, end) for edge in state.graph.edges.values() for end in (0, 1)]
    for edge, end in ends:
        place = _at_end(state, edge.ends[end], state.maps.seen_from(edge.id, end), sight, back)
        if place is not None:
            sight_in_node, evidence = place
            evidence -= math.log(len(ends))
            found.append(arrived(state, edge.ends[end].node, sight, sight_in_node, edge_map, evidence))
    return found


def arrived(
    state: AtlasState, node: int, sight: Sight, sight_in_node: UncertainPose, edge_map: EdgeMap, evidence: float
) -> Place:
    """Return the place at a node that a sight shows, ``evidence`` being that without the view's."""
    there = state.graph.nodes[node]
    keys = align_branches(there, sight, sight_in_node.pose, state.config)
    edge_in_node = sight_in_node @ UncertainPose.exact(SE2(edge_map.terminal_x, 0.0, math.pi).inverse())
    evidence += view_evidence(there, sight)
    return Place(node, edge_in_node, edge_map.traversal, evidence, keys, sight.come_along)


def _at_end(
    state: AtlasState, here: EdgeEnd, stored: EdgeMap, sight: Sight, back: EdgeMap
) -> tuple[UncertainPose, float] | None:
    """Return the sight's pose in the node at an edge's end, come to along it, and the evidence; None without a match.

    ``stored`` and ``back``, what was seen on the way there, have their origins at the node.
    """
    bearing = _bearing(state.graph, here)
    heading = wrap(bearing - sight.bearings[sight.come_along] - here.frame_in_node.pose.theta)
    position = 2.0 * state.config.origin_repeat_m**2
    spread = np.diag([position, position, _HEADING_STD**2])
    matches = [
        match_constellations(stored, back, SE2(0.0, 0.0, wrap(heading + start)), spread, state.config)
        for start in _STARTS
    ]
    best = max(matches, key=lambda match: (match.agrees, match.evidence))
    if not best.agrees:
        return None
    offset = UncertainPose(best.alignment.offset, best.alignment.offset_covariance)
    return UncertainPose.exact(here.frame_in_node.pose) @ offset, state.look_alikes.capped(best.evidence)


def _bearing(graph: AtlasGraph, end: EdgeEnd) -> float:
    """Return the direction in which an edge leaves its node (rad, in the node's frame)."""
    return graph.nodes[end.node].branches[end.branch].bearing
