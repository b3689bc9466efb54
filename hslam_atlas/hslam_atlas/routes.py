"""Shortest ways along known edges: one Dijkstra, one cost of a hop."""

import heapq
import math
from collections.abc import Collection, Iterator
from typing import NamedTuple

from hslam_atlas.graph import AtlasGraph

PER_NODE_M = 6.0
"""What stopping at one more node costs, in metres."""

PER_FAILURE_M = 20.0
"""What it costs to count on a branch that was not there or led elsewhere, by every such time in a row, in metres."""


class Reached(NamedTuple):
    """A node and the shortest way to it."""

    node: int
    cost_m: float
    """Path length, and `PER_NODE_M` for every node arrived at."""
    first: int
    """The branch the way leaves its start by."""


def outward(
    graph: AtlasGraph, start: int, by: Collection[int], closed: Collection[int] = frozenset(), tries: float = math.inf
) -> Iterator[Reached]:
    """Yield every node that known edges lead to, nearest first, as far as it is asked for.

    The ways leave ``start`` by one of the branches ``by``; it is itself yielded as a place to come back to, since a
    branch that is not in sight now may be then. The edges ``closed`` are not driven, nor is a branch that was not
    there or led elsewhere ``tries`` times in a row.
    """
    queue: list[tuple[float, int, int]] = []
    for key in by:
        _push(graph, queue, Reached(start, 0.0, key), key, closed, tries)
    done: set[int] = set()
    while queue:
        reached = Reached(*_in_order(heapq.heappop(queue)))
        if reached.node in done:
            continue
        done.add(reached.node)
        yield reached
        for key in graph.nodes[reached.node].branches:
            _push(graph, queue, reached, key, closed, tries)


def _in_order(entry: tuple[float, int, int]) -> tuple[int, float, int]:
    cost, node, first = entry
    return node, cost, first


def _push(
    graph: AtlasGraph,
    queue: list[tuple[float, int, int]],
    at: Reached,
    key: int,
    closed: Collection[int],
    tries: float,
) -> None:
    """Queue the node a branch leads to."""
    branch = graph.nodes[at.node].branches[key]
    in_vain = branch.attempts + (branch.unseen if at.cost_m else 0)  # from the start leave only branches in sight
    if branch.edge is None or branch.edge in closed or in_vain >= tries:
        return
    edge = graph.edges[branch.edge]
    cost_m = at.cost_m + edge.path_length_m + PER_NODE_M + PER_FAILURE_M * in_vain
    heapq.heappush(queue, (cost_m, edge.ends[1 - edge.end_at(at.node, key)].node, at.first))
