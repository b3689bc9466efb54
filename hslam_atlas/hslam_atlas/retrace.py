"""Drives along known edges: is this the same edge, and if so, what does the drive add to its map?"""

import math
from dataclasses import replace

import numpy as np

from hslam_atlas.config import AtlasConfig
from hslam_atlas.fusion import fuse
from hslam_atlas.graph import Edge, EdgeEnd
from hslam_atlas.map_match import MapMatch, match_constellations, match_edges, near
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2, wrap

_FEW_LANDMARKS = 4
"""With fewer landmarks than this in either map, lengths must do."""
_SHORT_M = 3.0
"""Below this length the direction of the edge frame is too uncertain to be taken as common."""
_STRAY = 4.0
"""Homing errs by several standard deviations now and then: the tie of the terminals must not part all other pairs."""
_HEADING_STD = math.radians(8.0)
"""Of one edge frame against another at the same node, where no common terminal turns both."""


def similar_length(a_m: float, b_m: float, config: AtlasConfig) -> bool:
    """Whether two path lengths may be of one edge."""
    return abs(a_m - b_m) < config.length_tolerance_m + config.length_tolerance * max(a_m, b_m)


def compare(
    state: AtlasState, edge: Edge, end: int, edge_map: EdgeMap, frame_in_node: UncertainPose
) -> MapMatch | None:
    """Match a drive's map with an edge's, both seen from the node at ``end``; None if lengths or directions differ.

    ``frame_in_node``: the drive's frame, origin at that node, in the node's frame.
    """
    if not similar_length(edge.path_length_m, edge_map.path_length_m, state.config):
        return None
    stored = state.maps.seen_from(edge.id, end)
    if abs(stored.terminal_x - edge_map.terminal_x) > state.config.length_tolerance_m:
        return None
    if not _leaves_alike(stored, edge_map, state.config) and not _arrives_alike(stored, edge_map, state.config):
        return None  # one of the two branches may be misread; if both are others, so is the way: one of a theta's
    match = _matched(state, edge, end, edge_map, frame_in_node, 1.0)
    if match.agrees:
        return match
    return max(match, _matched(state, edge, end, edge_map, frame_in_node, _STRAY), key=lambda m: (m.agrees, m.evidence))


def _leaves_alike(stored: EdgeMap, edge_map: EdgeMap, config: AtlasConfig) -> bool:
    """Whether two maps of one frame set out in one direction."""
    return abs(wrap(stored.departure_heading - edge_map.departure_heading)) < config.branch_gate


def _arrives_alike(stored: EdgeMap, edge_map: EdgeMap, config: AtlasConfig) -> bool:
    """Whether two maps of one frame arrive from one direction."""
    return abs(wrap(stored.arrival_heading - edge_map.arrival_heading)) < config.branch_gate


def _matched(
    state: AtlasState, edge: Edge, end: int, edge_map: EdgeMap, frame_in_node: UncertainPose, stray: float
) -> MapMatch:
    """Match a drive's map with an edge's, meet points repeating ``stray`` times worse than they mostly do."""
    stored = state.maps.seen_from(edge.id, end)
    near, far = (stray * _repeat_m(state, edge.ends[i].node) for i in (end, 1 - end))
    if stored.terminal_x >= _SHORT_M:  # both x axes pass through the same two meet points
        heading, heading_std = 0.0, (near + far) / stored.terminal_x + math.radians(0.1)
    else:
        heading = wrap(frame_in_node.pose.theta - edge.ends[end].frame_in_node.pose.theta)
        heading_std = _HEADING_STD
    prior = np.diag([2.0 * near**2, 2.0 * near**2, heading_std**2])
    return match_edges(stored, edge_map, SE2(0.0, 0.0, heading), prior, math.sqrt(2.0) * far, state.config)


def on_one_way(state: AtlasState, edge: Edge, end: int, edge_map: EdgeMap, frame_in_node: UncertainPose) -> bool:
    """Whether a drive and an edge of different lengths can have left a node by one branch: what both passed must match.

    Arguments as for `compare`.  Too few landmarks on the common part speak neither way.
    """
    stored = state.maps.seen_from(edge.id, end)
    if not _on_the_way(state, edge, end, edge_map, frame_in_node):
        return False
    common_m = min(stored.terminal_x, edge_map.terminal_x)
    fewest = min(len(near(stored, common_m)), len(near(edge_map, common_m)))
    if fewest < _FEW_LANDMARKS:
        return True
    heading = wrap(frame_in_node.pose.theta - edge.ends[end].frame_in_node.pose.theta)
    repeat = _repeat_m(state, edge.ends[end].node)
    prior = np.diag([2.0 * repeat**2, 2.0 * repeat**2, _HEADING_STD**2])
    match = match_constellations(stored, edge_map, SE2(0.0, 0.0, heading), prior, state.config, common_m)
    # The longer one may come back past the node: it shows more than what both passed.
    return len(match.alignment.pairs) >= state.config.least_fraction * fewest


def _on_the_way(state: AtlasState, edge: Edge, end: int, edge_map: EdgeMap, frame_in_node: UncertainPose) -> bool:
    """Whether the shorter's end is near enough to the longer's to lie on its way."""
    known = edge.ends[end].frame_in_node.pose.apply(edge.terminal_x, 0.0)
    found = frame_in_node.pose.apply(edge_map.terminal_x, 0.0)
    rest_m = abs(edge.path_length_m - edge_map.path_length_m)
    longer_m = max(edge.path_length_m, edge_map.path_length_m)
    return math.dist(known, found) < rest_m + state.config.length_tolerance_m + state.config.length_tolerance * longer_m


def _repeat_m(state: AtlasState, node: int) -> float:
    """Return how well a node's position repeats between visits."""
    meets = state.graph.nodes[node].kind is NodeKind.MEET_POINT
    return state.config.origin_repeat_m if meets else state.config.boundary_repeat_m


def convinces(match: MapMatch | None, edge: Edge, edge_map: EdgeMap, state: AtlasState) -> bool:
    """Whether a drive where this edge was expected has indeed followed it."""
    if match is None:
        return False
    if min(state.maps.get(edge.id).size, edge_map.size) < _FEW_LANDMARKS:
        return True
    return match.agrees


def far_end(edge_map: EdgeMap) -> UncertainPose:
    """Return the frame at a map's terminal, x back to its origin, in the map's frame."""
    variance = float(edge_map.covariance[0, 0])
    return UncertainPose(SE2(edge_map.terminal_x, 0.0, math.pi), np.diag([variance, 0.0, 0.0]))


def far_sight_in_node(edge: Edge, end: int, edge_map: EdgeMap, match: MapMatch) -> UncertainPose:
    """Return where the drive's far end frame (origin at its terminal, x back) sits in the far node's frame."""
    there = edge.ends[1 - end].frame_in_node
    back = SE2(edge.terminal_x, 0.0, math.pi).inverse()
    offset = back @ match.alignment.offset @ SE2(edge_map.terminal_x, 0.0, math.pi)
    # The terminals were tied: at the far end the frames differ by how well a node repeats.
    spread = UncertainPose.diagonal(offset, 0.03, max(math.sqrt(float(match.alignment.offset_covariance[2, 2])), 0.004))
    return UncertainPose.exact(there.pose) @ spread


def update(
    state: AtlasState, edge: Edge, end: int, edge_map: EdgeMap, match: MapMatch, drives: tuple[int, ...] = ()
) -> Edge:
    """Fuse a map (seen from ``end``) into the edge's, unless it shares a drive with it: no measurement counts twice.

    ``drives``: the traversals the map holds, its own if not given.  Returns the edge as it is now.
    """
    drives = drives or (edge_map.traversal,)
    if set(drives) & set(edge.traversals) or not match.agrees:
        return edge
    stored = state.maps.seen_from(edge.id, end)
    counts = len(edge.traversals), len(drives)
    fused, turn = fuse(stored, edge_map, match.alignment, counts, forget_below=state.config.forget_below)
    new_in_old = SE2(0.0, 0.0, turn)
    near, far = edge.ends[end], edge.ends[1 - end]
    over = SE2(edge.terminal_x, 0.0, math.pi).inverse() @ new_in_old @ SE2(fused.terminal_x, 0.0, math.pi)
    moved_near = near._replace(frame_in_node=_moved(near, new_in_old))
    moved_far = far._replace(frame_in_node=_moved(far, over))
    updated = replace(
        edge,
        ends=(moved_near, moved_far) if end == 0 else (moved_far, moved_near),
        terminal_x=fused.terminal_x,
        terminal_variance=float(fused.covariance[0, 0]),
        path_length_m=fused.path_length_m,
        traversals=(*edge.traversals, *drives),
    )
    state.maps.put(edge.id, fused if end == 0 else reverse(fused))
    state.graph.put_edge(updated)
    return updated


def _moved(end: EdgeEnd, by: SE2) -> UncertainPose:
    """Return an end's frame after the edge frame has moved by a known pose."""
    return end.frame_in_node @ UncertainPose.exact(by)
