"""Read an event: the node it shows, in the frame the atlas compares it in, and what it says of a stored node."""

import math

from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import AtlasError
from hslam_atlas.graph import Node
from hslam_atlas.hypothesis import Hypothesis, Sight, align_branches
from hslam_atlas.questions import Question
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import GvgEvent, NodeView
from hslam_types.se2 import SE2, wrap


def open_question(node: int, hypothesis: Hypothesis) -> Question:
    """Return the question a hypothesis about a node leaves open."""
    h = hypothesis
    return Question(node, h.node, h.sight_in_node, h.place_evidence, (h.map_evidence or 0.0,))


def sight_of(event: GvgEvent, edge_map: EdgeMap) -> Sight:
    """Express an arrival's node view in the frame at the terminal, x back to the origin."""
    view = view_of(event)
    reference = view.reference_bearing(event.branch)
    bearings = tuple(
        wrap(edge_map.arrival_heading - math.pi + bearing - reference) for bearing in view.bearings_in_odom
    )
    return Sight(view.kind, view.clearance_m, bearings, event.branch, reverse(edge_map))


def view_of(event: GvgEvent) -> NodeView:
    """Return the node a departure or arrival shows; raises AtlasError where there is none."""
    if event.node is None:
        raise AtlasError(f"event {event.sequence} ({event.kind.name}) shows no node")
    return event.node


def branch_towards(node: Node, heading: float, keys: tuple[int, ...], index: int, view: NodeView) -> int:
    """Return the branch departed by: the announced index if it fits the measured heading, else the nearest."""
    announced = keys[index] if view.degree == len(keys) else None
    if announced is not None and abs(wrap(node.branches[announced].bearing - heading)) < math.radians(50.0):
        return announced
    return min(node.branches.values(), key=lambda branch: (abs(wrap(branch.bearing - heading)), branch.key)).key


def observe(node: Node, sight: Sight, sight_in_node: SE2, config: AtlasConfig) -> tuple[int, ...]:
    """Count which of a node's branches a visit shows and which not; add new ones, give up those mostly not there.

    Returns the node's key for each of the sight's branches.
    """
    keys: list[int] = []
    for bearing, known in zip(sight.bearings, align_branches(node, sight, sight_in_node, config), strict=True):
        in_node = wrap(bearing + sight_in_node.theta)
        if known is None:
            branch = node.add_branch(in_node)
            branch.missed = len(node.visits)
        else:
            branch = node.branches[known]
            branch.seen += 1
            branch.bearing = wrap(branch.bearing + wrap(in_node - branch.bearing) / branch.seen)
        keys.append(branch.key)
    for branch in node.branches.values():
        shown = branch.key in keys
        branch.missed += int(not shown)
        branch.unseen = 0 if shown else branch.unseen + 1
        branch.give_up_if_absent()
    return tuple(keys)
