"""Enter a drive between two identified nodes into the graph, whatever its two branches already carry.

A branch leads along one edge only.  So where a branch is taken, the drive either was along that edge (then the far
ends are one node), or was shorter (the stored edge had passed a node unnoticed: it is taken out and its other end is
explored again), or was longer (this drive passed a node unnoticed: it says where things lie, but is no edge).  In the
last two cases both saw the same walls as far as the shorter one goes.  If not, one of them is not of this branch: the
edge, if only one drive ever showed it, else the drive.
"""

from dataclasses import dataclass, replace
from enum import Enum, auto

from hslam_atlas.graph import Edge, EdgeEnd
from hslam_atlas.merge import merge, take_out
from hslam_atlas.retrace import compare, convinces, far_end, far_sight_in_node, on_one_way, similar_length, update
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import NodeKind

_LEAST_LOOP = 3.2
"""A way from a node back to itself shorter than this many clearances goes round nothing (rule 6 of the reduced GVG)."""


class Outcome(Enum):
    """What became of a drive."""

    CONNECTED = auto()
    """A new edge."""
    RETRACED = auto()
    """A known edge driven again."""
    GLUED = auto()
    """A known edge driven from a node that turned out to be known too."""
    PASSED = auto()
    """A node was overlooked on the way: no edge, but a link."""
    RETURNED = auto()
    """The robot came back along the branch it left by, or went round nothing."""
    CONTRADICTED = auto()
    """The two nodes cannot be connected so: the identification must be wrong."""


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """A traversal between a branch of one node and a branch of another, the robot's map of it and its end frames."""

    start: EdgeEnd
    """Frame: the map's."""
    stop: EdgeEnd
    """Frame: origin at the terminal, x back."""
    edge_map: EdgeMap


def tie(state: AtlasState, drive: Drive, *, sure: bool = False) -> Outcome:
    """Enter the drive; on CONTRADICTED and PASSED no edge is touched.

    ``sure``: its end is beyond doubt.  Then what contradicts is an edge or a branch, never the node.
    """
    outcome = _entered(state, drive, sure=sure)
    if outcome is Outcome.CONNECTED:
        state.graph.nodes[drive.start.node].branches[drive.start.branch].attempts = 0
        connect(state, _beside(state, drive))
    elif outcome in (Outcome.PASSED, Outcome.RETURNED):
        fruitless(state, drive)
    elif outcome is Outcome.RETRACED and sure:
        _doubt(state, drive)
    return outcome


def _entered(state: AtlasState, drive: Drive, *, sure: bool) -> Outcome:
    """Return what becomes of a drive; CONNECTED where it is to become an edge, and what stood in its way is out."""
    if _goes_nowhere(state, drive):
        return Outcome.RETURNED
    if _driven_between(state, drive):
        return Outcome.RETRACED
    back = reverse(drive.edge_map)
    obsolete: list[int] = []
    for near, far, edge_map in ((drive.stop, drive.start, back), (drive.start, drive.stop, drive.edge_map)):
        edge_id = state.graph.nodes[near.node].branches[near.branch].edge
        if edge_id is None:
            continue
        met = _met(state, state.graph.edges[edge_id], edge_map, (near, far), sure=sure)
        if met is Outcome.CONTRADICTED and sure:
            if near is drive.stop:
                continue  # the way into a node is read less well than the way out of it: a branch beside
            met = Outcome.CONNECTED if _refuted(state, near) else Outcome.PASSED
        if met is not Outcome.CONNECTED:
            return met
        obsolete.append(edge_id)
    for edge_id in obsolete:
        if edge_id in state.graph.edges:
            take_out(state, edge_id)
    return Outcome.CONNECTED


def _refuted(state: AtlasState, start: EdgeEnd) -> bool:
    """Whether, with one more drive that ended elsewhere, a branch's edge has misled as often as it was driven."""
    branch = state.graph.nodes[start.node].branches[start.branch]
    return branch.edge is not None and len(state.graph.edges[branch.edge].traversals) <= branch.attempts + 1


def _doubt(state: AtlasState, drive: Drive) -> None:
    """Count a drive along a known edge against another edge, the one its branch was taken to carry."""
    branch = state.graph.nodes[drive.start.node].branches[drive.start.branch]
    if branch.edge is None or drive.stop.node in {end.node for end in state.graph.edges[branch.edge].ends}:
        return
    if _refuted(state, drive.start):
        take_out(state, branch.edge)
        branch.given_up = True  # it is the branch of the edge driven, seen in another direction
    branch.fail(state.config.attempts)
    state.graph.changed_nodes.add(drive.start.node)


def _met(state: AtlasState, edge: Edge, edge_map: EdgeMap, ends: tuple[EdgeEnd, EdgeEnd], *, sure: bool) -> Outcome:
    """Return what becomes of a drive whose near end is on an edge's branch; CONNECTED if it takes the edge's place."""
    near, far = ends
    end = edge.end_at(near.node, near.branch)
    if similar_length(edge.path_length_m, edge_map.path_length_m, state.config):
        return _same(state, edge, end, edge_map, near, far)
    if sure and not on_one_way(state, edge, end, edge_map, near.frame_in_node):
        return Outcome.CONTRADICTED
    if _dead_end(state, far) or not _yields(state, edge, end, edge_map, near.frame_in_node):
        return Outcome.PASSED
    return Outcome.CONNECTED


def _beside(state: AtlasState, drive: Drive) -> Drive:
    """Return the drive between branches of its own where those it was taken to use carry an edge."""
    start, stop = drive.start, drive.stop
    leaves = start.frame_in_node.pose.theta + drive.edge_map.departure_heading
    comes = stop.frame_in_node.pose.theta + reverse(drive.edge_map).departure_heading
    return replace(drive, start=_free(state, start, leaves), stop=_free(state, stop, comes))


def _free(state: AtlasState, end: EdgeEnd, bearing: float) -> EdgeEnd:
    """Return an end on a branch that carries no edge: its own, or else a new one in the direction driven."""
    node = state.graph.nodes[end.node]
    if node.branches[end.branch].edge is None:
        return end
    return end._replace(branch=node.add_branch(bearing).key)


def _goes_nowhere(state: AtlasState, drive: Drive) -> bool:
    """Whether the robot came back where it left, along the same branch or round nothing."""
    if drive.start.node != drive.stop.node:
        return False
    least_m = _LEAST_LOOP * state.graph.nodes[drive.start.node].clearance_m
    return drive.start.branch == drive.stop.branch or drive.edge_map.path_length_m < least_m


def _driven_between(state: AtlasState, drive: Drive) -> bool:
    """Recognise an edge between the same two nodes, driven from or into a branch that was invented beside it."""
    start, stop = state.graph.nodes[drive.start.node], state.graph.nodes[drive.stop.node]
    own = start.branches[drive.start.branch], stop.branches[drive.stop.branch]
    for branch in start.ordered():
        edge = None if branch.edge is None else state.graph.edges[branch.edge]
        if edge is None or edge.id in {own[0].edge, own[1].edge}:
            continue
        end = edge.end_at(start.id, branch.key)
        if edge.ends[1 - end].node != stop.id:
            continue
        match = compare(state, edge, end, drive.edge_map, drive.start.frame_in_node)
        if match is not None and match.agrees:
            for invented in own:
                invented.given_up |= invented.edge is None
            state.graph.changed_nodes.update((start.id, stop.id))
            update(state, edge, end, drive.edge_map, match)
            return True
    return False


def connect(state: AtlasState, drive: Drive) -> Edge:
    """Make the drive a new edge with its map; both branches must be free."""
    edge_map = drive.edge_map
    edge = state.graph.connect(
        (drive.start, drive.stop),
        edge_map.terminal_x,
        float(edge_map.covariance[0, 0]),
        edge_map.path_length_m,
        edge_map.traversal,
    )
    state.maps.put(edge.id, edge_map)
    return edge


def is_refuted(state: AtlasState, edge_id: int, start: EdgeEnd, edge_map: EdgeMap) -> bool:
    """Whether an edge cannot stay, given that a drive which set out along it ended at a node it does not lead to."""
    edge = state.graph.edges[edge_id]
    if similar_length(edge.path_length_m, edge_map.path_length_m, state.config):
        return False
    return _yields(state, edge, edge.end_at(start.node, start.branch), edge_map, start.frame_in_node)


def _dead_end(state: AtlasState, far: EdgeEnd) -> bool:
    """Whether a drive's other end is a boundary point: no longer edge can have passed one unnoticed."""
    return state.graph.nodes[far.node].kind is NodeKind.BOUNDARY_POINT


def _yields(state: AtlasState, edge: Edge, end: int, edge_map: EdgeMap, frame_in_node: UncertainPose) -> bool:
    """Whether an edge gives way to a drive of another length on its branch."""
    if on_one_way(state, edge, end, edge_map, frame_in_node):
        return edge_map.path_length_m < edge.path_length_m
    return len(edge.traversals) == 1


def _same(state: AtlasState, edge: Edge, end: int, edge_map: EdgeMap, near: EdgeEnd, far: EdgeEnd) -> Outcome:
    """The drive has the length of the edge on ``near``'s branch: they must be one, and so must their far ends."""
    match = compare(state, edge, end, edge_map, near.frame_in_node)
    if match is None or not convinces(match, edge, edge_map, state):
        return Outcome.CONTRADICTED
    known = edge.ends[1 - end]
    if known.node == far.node:
        if known.branch != far.branch:  # a branch that was invented, or one branch seen in two directions
            state.graph.nodes[far.node].branches[far.branch].given_up = True
            state.graph.changed_nodes.add(far.node)
        update(state, edge, end, edge_map, match)
        return Outcome.RETRACED
    far_in_known = far_sight_in_node(edge, end, edge_map, match) @ far.frame_in_node.inverse()
    if not merge(state, far.node, known.node, far_in_known):
        return Outcome.CONTRADICTED
    if edge.id in state.graph.edges:
        update(state, state.graph.edges[edge.id], end, edge_map, match)
    return Outcome.GLUED


def fruitless(state: AtlasState, drive: Drive) -> None:
    """Count a drive that brought no edge against the branch it set out on; remember what it measured."""
    state.graph.nodes[drive.start.node].branches[drive.start.branch].fail(state.config.attempts)
    state.graph.changed_nodes.add(drive.start.node)
    if drive.start.node != drive.stop.node:
        link(state, drive)
        state.loosened.add(drive.start.node)


def link(state: AtlasState, drive: Drive) -> None:
    """Keep the relative pose of the drive's two nodes."""
    stop_in_start = drive.start.frame_in_node @ far_end(drive.edge_map) @ drive.stop.frame_in_node.inverse()
    state.graph.add_link(drive.start.node, drive.stop.node, stop_in_start, drive.edge_map.path_length_m)
