"""Shortest ways along known edges: one Dijkstra, one cost of a hop."""

import heapq
from collections.abc import Collection, Iterator
from typing import NamedTuple

from hslam_atlas.graph import AtlasGraph

PER_NODE_M = 6.0
"""What stopping at one more node costs, in metres."""


class Reached(NamedTuple):
    """A node and the shortest way to it."""

    node: int
    cost_m: float
    """Path length, and `PER_NODE_M` for every node arrived at."""
    first: int
    """The branch the way leaves its start by."""


def outward(
    graph: AtlasGraph, start: int, by: Collection[int], closed: Collection[int] = frozenset()
) -> Iterator[Reached]:
    """Yield every other node that known edges lead to, nearest first, as far as it is asked for.

    The ways leave ``start`` by one of the branches ``by``; the edges ``closed`` are not driven.
    """
    queue: list[tuple[float, int, int]] = []
    for key in by:
        _push(graph, queue, Reached(start, 0.0, key), key, closed)
    done = {start}
    while queue:
        reached = Reached(*_in_order(heapq.heappop(queue)))
        if reached.node in done:
            continue
        done.add(reached.node)
        yield reached
        for key in graph.nodes[reached.node].branches:
            _push(graph, queue, reached, key, closed)


def _in_order(entry: tuple[float, int, int]) -> tuple[int, float, int]:
    cost, node, first = entry
    return node, cost, first


def _push(
    graph: AtlasGraph, queue: list[tuple[float, int, int]], at: Reached, key: int, closed: Collection[int]
) -> None:
    """Queue the node a branch leads to."""
    edge_id = graph.nodes[at.node].branches[key].edge
    if edge_id is not None and edge_id not in closed:
        edge = graph.edges[edge_id]
        far = edge.ends[1 - edge.end_at(at.node, key)]
        heapq.heappush(queue, (at.cost_m + edge.path_length_m + PER_NODE_M, far.node, at.first))
