"""Where nodes lie relative to one another: poses composed along the shortest chain of edges, when asked for."""

import heapq

from hslam_atlas.graph import AtlasGraph
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.se2 import SE2

_PER_HOP_M = 3.0
"""What one more frame change costs a chain, in metres of path."""


def chained(graph: AtlasGraph, start: int) -> dict[int, UncertainPose]:
    """Return every reachable node's pose in ``start``'s frame along the path of least length, nearest first."""
    found: dict[int, UncertainPose] = {}
    queue: list[tuple[float, int, int]] = [(0.0, start, 0)]
    poses = {0: UncertainPose.exact(SE2())}
    counter = 0
    while queue:
        cost, node, ticket = heapq.heappop(queue)
        pose = poses.pop(ticket)
        if node in found:
            continue
        found[node] = pose
        for other, other_in_node, length in graph.neighbours(node):
            if other not in found:
                counter += 1
                poses[counter] = pose @ other_in_node
                heapq.heappush(queue, (cost + length + _PER_HOP_M, other, counter))
    return found
