"""Edges worth driving once more when nothing unexplored is in reach: they may have passed a node unnoticed.

A node that was noticed on one drive and passed on the others is an island: the drives that passed it are edges, and
none of them leads there. Where such edges run is not kept, but how long they are is: a node can only lie on an edge if
the way by it from end to end is no longer.
"""

import math
from collections import Counter

from hslam_atlas.chain import chained
from hslam_atlas.graph import Edge
from hslam_atlas.routes import Reached, outward
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_atlas.whereabouts import Here

_SLACK_M = 1.0
"""An edge may seem this much too short for the way by a node on it: meet points scatter, and drives cut corners."""
_LOOKS = 2
"""So often an edge is driven for it: once from each side, as a rule."""


class SecondLooks:
    """Remembers how often each edge was driven for another look."""

    def __init__(self, state: AtlasState) -> None:
        """Begin with none."""
        self._state = state
        self._looks: Counter[int] = Counter()

    def next_branch(self, here: Here) -> int | None:
        """Return the branch to leave by for the nearest edge worth another look; None where there is none."""
        graph = self._state.graph
        ways = list(outward(graph, here.node, here.keys, tries=self._state.config.attempts))
        worth = self._worth(here, ways)
        branches = graph.nodes[here.node].branches
        for key in here.keys:
            if (edge := branches[key].edge) in worth and edge is not None:
                self._looks[edge] += 1
                return key
        for reached in ways:
            if any(branch.edge in worth for branch in graph.nodes[reached.node].branches.values()):
                return reached.first
        return None

    def _worth(self, here: Here, ways: list[Reached]) -> set[int]:
        """Return the edges in reach that may have passed an island, or that were driven once where twice is asked."""
        graph, poses = self._state.graph, chained(self._state.graph, here.node)
        reach = {here.node, *(reached.node for reached in ways)}
        islands = [
            poses[node.id]
            for node in graph.nodes.values()
            if node.id not in reach and node.id in poses and any(b.unexplored for b in node.branches.values())
        ]
        found = set[int]()
        for edge in graph.edges.values():
            if self._looks[edge.id] >= _LOOKS or not reach.issuperset(end.node for end in edge.ends):
                continue
            once = self._state.config.drive_twice and len(edge.traversals) == 1
            if once or any(_may_pass(edge, poses, island) for island in islands):
                found.add(edge.id)
        return found


def _may_pass(edge: Edge, poses: dict[int, UncertainPose], island: UncertainPose) -> bool:
    """Whether a place may lie on an edge: the way by it is not longer."""
    ends = (poses[end.node].pose for end in edge.ends)
    by_m = sum(math.hypot(end.x - island.pose.x, end.y - island.pose.y) for end in ends)
    return by_m <= edge.path_length_m + _SLACK_M
