"""Where to drive next: confirm a doubtful node by a known edge, else the nearest unexplored branch (Dijkstra).

Of several unexplored branches of the node the robot is at, the one that turns most sharply back goes first: it keeps to
one region, closes the small loops and leaves no dead end behind to come back for.
"""

from hslam_atlas.graph import AtlasGraph
from hslam_atlas.merge import branch_partners
from hslam_atlas.questions import Questions
from hslam_atlas.routes import outward
from hslam_atlas.state import AtlasState
from hslam_atlas.whereabouts import Here
from hslam_types.se2 import wrap


def next_branch(state: AtlasState, questions: Questions, here: Here) -> int | None:
    """Return the key of the branch to trace from here, or None if nothing is left to explore."""
    confirming = _confirming(state, questions, here)
    if confirming is not None:
        return confirming
    return _towards_unexplored(state, here)


def unexplored(graph: AtlasGraph) -> int:
    """Return how many branches are left unexplored."""
    return sum(branch.unexplored for node in graph.nodes.values() for branch in node.branches.values())


def driven_once(graph: AtlasGraph) -> int:
    """Return how many edges were driven once only."""
    return sum(len(edge.traversals) == 1 for edge in graph.edges.values())


def _confirming(state: AtlasState, questions: Questions, here: Here) -> int | None:
    """Return a new branch that, if this node is the one suspected, is a known edge: the shortest such."""
    node = state.graph.nodes[here.node]
    for question in questions.of(here.node):
        if questions.evidence(question) < state.config.confirm_evidence:
            break
        other = state.graph.nodes[question.other]
        partners = branch_partners(node, other, question.node_in_other, state.config.branch_gate)
        offers: list[tuple[float, int]] = []
        for key, onto in partners.items():
            edge_id = None if onto is None else other.branches[onto].edge
            if edge_id is not None and node.branches[key].unexplored and key in here.keys:
                offers.append((state.graph.edges[edge_id].path_length_m, key))
        if offers:
            return min(offers)[1]
    return None


def _towards_unexplored(state: AtlasState, here: Here) -> int | None:
    """Return the first branch of the shortest way to an unexplored one, leaving by a branch seen on this visit.

    A branch of this very node that is not in sight is last: it may be when the robot comes back.
    """
    graph = state.graph
    branches = graph.nodes[here.node].branches
    free = [key for key in here.keys if branches[key].unexplored]
    if free:
        back = None if here.come is None else branches[here.come].bearing
        return min(free, key=lambda key: 0.0 if back is None else abs(wrap(branches[key].bearing - back)))
    again = None
    for reached in outward(graph, here.node, here.keys, tries=state.config.attempts):
        if reached.node == here.node:
            again = reached.first
        elif any(branch.unexplored for branch in graph.nodes[reached.node].branches.values()):
            return reached.first
    hoped = any(branch.unexplored and branch.unseen < state.config.attempts for branch in branches.values())
    return again if hoped else None
