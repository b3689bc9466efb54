"""Make two nodes one, with all that follows: edges on the same branch become one, so do their far ends.

The consequences are checked before anything is changed: one contradiction (kinds, lengths, maps) and the merge
is refused.  One pair of edges may differ in length if their maps agree as far as the shorter one goes: then the
longer had passed a node unnoticed, and is taken out.
"""

from collections import deque
from dataclasses import dataclass, replace

from hslam_atlas.branches import match_bearings
from hslam_atlas.graph import Node
from hslam_atlas.map_match import MapMatch
from hslam_atlas.retrace import compare, convinces, far_sight_in_node, on_one_way, similar_length, update
from hslam_atlas.state import AtlasState, Merged
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.se2 import wrap


@dataclass(frozen=True, slots=True)
class _Twin:
    """Two edges found to be one."""

    gone: int
    gone_end: int
    kept: int
    kept_end: int
    far: tuple[int, int, UncertainPose]
    """Their nodes at the far ends, with the pose of the first in the second: these are one too."""


@dataclass(frozen=True, slots=True)
class _Union:
    """Two nodes to be joined and the twin edges between them and theirs."""

    gone: int
    kept: int
    gone_in_kept: UncertainPose
    branches: dict[int, int | None]
    twins: tuple[_Twin, ...]
    obsolete: tuple[int, ...]
    """Edges that had passed a node unnoticed."""
    against: tuple[int, ...]
    """Branches of ``gone`` whose edge cannot be the one on the same branch of ``kept``."""


_OVERLOOKED_MOST = 1
"""Nodes that may have been passed unnoticed, for all that one merge brings together: two are another place."""


def merge(state: AtlasState, gone: int, kept: int, gone_in_kept: UncertainPose, *, sure: bool = False) -> bool:
    """Join two nodes (the older id stays) and all that follows; False, and nothing changed, if that contradicts.

    ``sure``: that they are one is beyond doubt.  Then edges that contradict are of different branches, and both stay.
    """
    if gone < kept:
        gone, kept, gone_in_kept = kept, gone, gone_in_kept.inverse()
    unions = _plan(state, gone, kept, gone_in_kept, sure=sure)
    if unions is None:
        return False
    for union in unions:
        _carry_out(state, union)
    state.closures += 1
    return True


@dataclass(frozen=True, slots=True)
class Consequence:
    """What `merge` would make one, the one gone first: pairs of nodes and of edges."""

    nodes: frozenset[tuple[int, int]]
    edges: frozenset[tuple[int, int]]


def consequence(state: AtlasState, gone: int, kept: int, gone_in_kept: UncertainPose) -> Consequence | None:
    """Return what `merge` would do, ``gone`` being the younger node; None where it would refuse. Nothing is changed."""
    unions = _plan(state, gone, kept, gone_in_kept, sure=False)
    if unions is None:
        return None
    nodes = frozenset((union.gone, union.kept) for union in unions)
    return Consequence(nodes, frozenset((twin.gone, twin.kept) for union in unions for twin in union.twins))


def branch_partners(gone: Node, kept: Node, gone_in_kept: UncertainPose, gate: float) -> dict[int, int | None]:
    """Return for each branch key of ``gone`` the key of ``kept``'s branch that lies in the same direction."""
    ordered = gone.ordered()
    bearings = [wrap(branch.bearing + gone_in_kept.pose.theta) for branch in ordered]
    known = [(branch.key, branch.bearing) for branch in kept.branches.values()]
    keys = match_bearings(bearings, known, gate)
    return {branch.key: key for branch, key in zip(ordered, keys, strict=True)}


def _plan(state: AtlasState, gone: int, kept: int, gone_in_kept: UncertainPose, *, sure: bool) -> list[_Union] | None:
    """Return every union that follows, or None if one is impossible."""
    graph = state.graph
    unions: list[_Union] = []
    partner: dict[int, int] = {}
    taken: set[int] = set()
    overlooked: set[int] = set()
    queue: deque[tuple[int, int, UncertainPose]] = deque([(gone, kept, gone_in_kept)])
    while queue:
        a, b, a_in_b = queue.popleft()
        if a == b or partner.get(a) == b:
            continue
        if a < b:
            a, b, a_in_b = b, a, a_in_b.inverse()
            if partner.get(a) == b:
                continue
        if a in partner or a in taken or b in partner:
            return None  # three nodes for one place: wait until the first two are one
        node, other = graph.nodes[a], graph.nodes[b]
        if node.kind is not other.kind or (not sure and abs(len(node.branches) - len(other.branches)) > 1):
            return None
        partner[a] = b
        taken.add(b)
        union = _union(state, node, other, a_in_b)
        if sure:
            union = _reconciled(state, union, partner, taken)
        if union.against:
            return None
        overlooked.update(union.obsolete)
        queue.extend(twin.far for twin in union.twins)
        unions.append(union)
    return unions if len(overlooked) <= _OVERLOOKED_MOST else None


def _reconciled(state: AtlasState, union: _Union, partner: dict[int, int], taken: set[int]) -> _Union:
    """Return a union without contradictions: edges that cannot be one, or whose far ends cannot be, are two."""
    apart = set(union.against)
    twins: list[_Twin] = []
    for twin in union.twins:
        far, other, _ = twin.far
        gone, kept = max(far, other), min(far, other)
        joined = gone == kept or partner.get(gone) == kept
        free = gone not in partner and gone not in taken and kept not in partner
        alike = state.graph.nodes[gone].kind is state.graph.nodes[kept].kind
        if joined or (free and alike):
            twins.append(twin)
        else:
            apart.add(state.graph.edges[twin.gone].ends[twin.gone_end].branch)
    branches = {key: None if key in apart else onto for key, onto in union.branches.items()}
    return replace(union, branches=branches, twins=tuple(twins), against=())


def _union(state: AtlasState, gone: Node, kept: Node, gone_in_kept: UncertainPose) -> _Union:
    """Return what joining two nodes does to the edges on their common branches."""
    graph = state.graph
    branches = branch_partners(gone, kept, gone_in_kept, state.config.branch_gate)
    twins: list[_Twin] = []
    obsolete: list[int] = []
    against: list[int] = []
    for key, onto in branches.items():
        edge_id = gone.branches[key].edge
        known_id = None if onto is None else kept.branches[onto].edge
        if edge_id is None or known_id is None or onto is None or edge_id == known_id:
            continue
        edge, known = graph.edges[edge_id], graph.edges[known_id]
        end, known_end = edge.end_at(gone.id, key), known.end_at(kept.id, onto)
        match = twin_match(state, edge_id, end, known_id, known_end, gone_in_kept)
        if match is not None and convinces(match, known, state.maps.get(edge_id), state):
            far = far_sight_in_node(known, known_end, state.maps.seen_from(edge_id, end), match)
            far_in_far = far @ edge.ends[1 - end].frame_in_node.inverse()
            far_ends = edge.ends[1 - end].node, known.ends[1 - known_end].node, far_in_far
            twins.append(_Twin(edge_id, end, known_id, known_end, far_ends))
        elif match is None and share_beginning(state, edge_id, end, known_id, known_end, gone_in_kept):
            obsolete.append(max((edge_id, known_id), key=lambda e: graph.edges[e].path_length_m))
        else:
            against.append(key)
    return _Union(gone.id, kept.id, gone_in_kept, branches, tuple(twins), tuple(obsolete), tuple(against))


def twin_match(
    state: AtlasState, edge_id: int, end: int, known_id: int, known_end: int, node_in_known: UncertainPose
) -> MapMatch | None:
    """Compare two stored edges as if the nodes at the given ends were one."""
    frame = node_in_known @ state.graph.edges[edge_id].ends[end].frame_in_node
    return compare(state, state.graph.edges[known_id], known_end, state.maps.seen_from(edge_id, end), frame)


def share_beginning(
    state: AtlasState, edge_id: int, end: int, known_id: int, known_end: int, node_in_known: UncertainPose
) -> bool:
    """Whether two stored edges of different lengths can be one way, if the nodes at the given ends are one."""
    edge, known = state.graph.edges[edge_id], state.graph.edges[known_id]
    if similar_length(edge.path_length_m, known.path_length_m, state.config):
        return False
    frame = node_in_known @ edge.ends[end].frame_in_node
    return on_one_way(state, known, known_end, state.maps.seen_from(edge_id, end), frame)


def take_out(state: AtlasState, edge_id: int) -> None:
    """Remove an edge found to pass a node; what it told of its ends' relative pose stays as a link."""
    edge = state.graph.remove_edge(edge_id)
    state.loosened.update(end.node for end in edge.ends)
    state.maps.drop(edge_id)
    if edge.ends[0].node != edge.ends[1].node:
        state.graph.add_link(edge.ends[0].node, edge.ends[1].node, edge.across(0), edge.path_length_m)


def _carry_out(state: AtlasState, union: _Union) -> None:
    """Fuse twin edges into the kept ones, then let the kept node absorb the other."""
    graph = state.graph
    for edge_id in union.obsolete:
        if edge_id in graph.edges:
            take_out(state, edge_id)
    for twin in union.twins:
        if twin.gone not in graph.edges or twin.kept not in graph.edges:
            continue  # already fused from its other end
        match = twin_match(state, twin.gone, twin.gone_end, twin.kept, twin.kept_end, union.gone_in_kept)
        if match is not None:
            drive = state.maps.seen_from(twin.gone, twin.gone_end)
            drives = graph.edges[twin.gone].traversals
            update(state, graph.edges[twin.kept], twin.kept_end, drive, match, drives)
        graph.remove_edge(twin.gone)
        state.maps.drop(twin.gone)
    kept = graph.nodes[union.kept]
    gone = graph.nodes[union.gone]
    for key, onto in union.branches.items():
        between = gone.branches[key].edge
        if between is not None and onto is not None and between == kept.branches[onto].edge:
            take_out(state, between)  # the robot had come back by the branch it left by: no edge leads so
    branches: dict[int, int] = {}
    for key, onto in union.branches.items():
        if onto is not None:
            branches[key] = onto
            continue
        added = kept.add_branch(gone.branches[key].bearing + union.gone_in_kept.pose.theta)
        added.seen = 0
        branches[key] = added.key
    graph.absorb(union.gone, union.kept, union.gone_in_kept, branches)
    state.merged.append(Merged(union.gone, union.kept, union.gone_in_kept, branches))
