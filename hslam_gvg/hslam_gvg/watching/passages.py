"""Which nodes of the local graph a robot has gone through, by its trail, wherever it drives between the walls.

Every place of the trail is retracted to the nearest point of the graph; nodes are gone through where that changes from
one branch to another.  Near a node it changes to and fro: there it belongs to the node, and a branch counts as taken
once the robot is well on it.
"""

from collections import deque
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from hslam_gvg.local_graph.local_graph import LocalGraph
from hslam_gvg.local_graph.polyline import arc_lengths
from hslam_types.se2 import Array

NODE_M, NODE_CLEARANCES, BRANCH_SHARE = 0.4, 0.6, 0.35
"""A place this near to a node, along the branch, belongs to the node: so far, so many of its clearances, but no more
than this share of the branch."""
END_M = 1.0
"""A dead end is seen before it is reached: who turns round this near to it has been there."""
TAKEN_M = 0.5
"""Who is this much farther on a branch, or half along it, has taken it."""
MOST_AT_ONCE = 3
"""More nodes than this are not gone through between two places of a trail: it leaps."""
OFF_M = 3.0
"""A place farther than this from the graph says nothing: the graph does not reach there."""


class Passage(NamedTuple):
    """A node gone through, its ways by their index in `LocalGraph.ways`."""

    node: int
    came_by: int
    left_by: int
    at: int
    """The place of the trail (its index) that was nearest to the node."""


class _Run(NamedTuple):
    """Part of a trail on one branch."""

    branch: int
    first: int
    last: int
    touched: frozenset[int]
    """The nodes that the trail was near to since the run before."""


@dataclass(frozen=True, slots=True)
class _Place:
    """A place of the trail, retracted to the graph."""

    index: int
    node: int | None
    """The node it belongs to, None where it is well on the branch."""
    branch: int
    beyond: tuple[float, float]
    """How far (m) it is beyond the zones of the nodes at the branch's ends."""


def passages(graph: LocalGraph, trail: Array) -> list[Passage] | None:
    """Return the nodes gone through by a trail (n x 2: m), in order; None where it leaps between ways that do not meet.

    The last one is told once the robot has taken the branch it left by.
    """
    runs = _runs(graph, trail)
    found: list[Passage] = []
    for run, after in pairwise(runs):
        nodes = _between(graph, run, after)
        if nodes is None:
            return None
        branches = [run.branch, *_joining(graph, nodes), after.branch]
        for node, came, left in zip(nodes, branches, branches[1:], strict=False):
            hub = graph.hub(node)
            near = np.hypot(trail[run.last : after.first + 1, 0] - hub.x, trail[run.last : after.first + 1, 1] - hub.y)
            at = run.last + int(np.argmin(near))
            found.append(Passage(node, _way(graph, node, came), _way(graph, node, left), at))
    counted = set(graph.nodes())
    return _without_glances(graph, [passage for passage in found if passage.node in counted], trail)


def _without_glances(graph: LocalGraph, found: list[Passage], trail: Array) -> list[Passage]:
    """Make one passage of two through a node that the robot did not leave between them: it looked into a branch."""
    kept: list[Passage] = []
    for passage in found:
        before = kept[-1] if kept else None
        if before is not None and before.node == passage.node:
            hub, between = graph.hub(passage.node), trail[before.at : passage.at + 1]
            away_m = float(np.hypot(between[:, 0] - hub.x, between[:, 1] - hub.y).max())
            if away_m < max(NODE_M, NODE_CLEARANCES * hub.clearance) + TAKEN_M:
                kept[-1] = Passage(passage.node, before.came_by, passage.left_by, passage.at)
                continue
        kept.append(passage)
    return kept


def _places(graph: LocalGraph, trail: Array) -> list[_Place]:
    """Retract the trail; places that the graph does not reach are left out."""
    paths = graph.paths()
    points = np.concatenate([path[:, :2] for _, path in paths])
    branches = np.concatenate([np.full(len(path), number) for number, path in paths])
    along = np.concatenate([arc_lengths(path) for _, path in paths])
    zones = {number: _zones(graph, number, path) for number, path in paths}
    lengths = {number: float(arc_lengths(path)[-1]) for number, path in paths}
    found = []
    for index, (off_m, point) in enumerate(zip(*cKDTree(points).query(trail[:, :2]), strict=True)):
        if off_m > OFF_M:
            continue
        branch, at_m = int(branches[point]), float(along[point])
        beyond = at_m - zones[branch][0], lengths[branch] - at_m - zones[branch][1]
        node = graph.ends(branch)[int(beyond[1] < beyond[0])] if min(beyond) < 0.0 else None
        found.append(_Place(index, node, branch, beyond))
    return found


def _runs(graph: LocalGraph, trail: Array) -> list[_Run]:
    """Return the parts of the trail that are surely on a branch; one that was hardly entered is none."""
    taken_m = {number: min(TAKEN_M, 0.3 * float(arc_lengths(path)[-1])) for number, path in graph.paths()}
    runs: list[_Run] = []
    touched: set[int] = set()
    for on_branch, group in groupby(
        _places(graph, trail), key=lambda place: place.branch if place.node is None else None
    ):
        places = list(group)
        if on_branch is None:
            touched.update(place.node for place in places if place.node is not None)
            continue
        ends = graph.ends(on_branch)
        sides = [side for side in (0, 1) if ends[side] in touched] or [0, 1]
        came_m = max(min(place.beyond[side] for side in sides) for place in places)
        if came_m >= taken_m[on_branch] or not (runs or touched):
            runs.append(_Run(on_branch, places[0].index, places[-1].index, frozenset(touched)))
            touched.clear()
    return runs


def _zones(graph: LocalGraph, branch: int, path: Array) -> tuple[float, float]:
    """Return how far along a branch a place still belongs to the node at its one end and at its other."""
    first, last = (_zone(graph, node, float(arc_lengths(path)[-1])) for node in graph.ends(branch))
    return first, last


def _zone(graph: LocalGraph, node: int, length_m: float) -> float:
    """Return how far along a branch a place still belongs to the node at its end."""
    if graph.is_exit(node):
        return 0.0
    hub = graph.hub(node)
    least_m = END_M if len(hub.ends) == 1 else NODE_M
    return min(max(least_m, NODE_CLEARANCES * hub.clearance), BRANCH_SHARE * length_m)


def _between(graph: LocalGraph, run: _Run, after: _Run) -> list[int] | None:
    """Return the nodes between two runs in order, the fewest that join their branches; None where nothing does."""
    if run.branch == after.branch:
        return [node for node in graph.ends(run.branch) if node in after.touched][:1]
    goals = set(graph.ends(after.branch))
    starts = sorted(set(graph.ends(run.branch)), key=lambda node: node not in after.touched)
    waiting: deque[tuple[int, ...]] = deque((start,) for start in starts)
    seen = set(starts)
    while waiting:
        way = waiting.popleft()
        if way[-1] in goals:
            return list(way)
        if len(way) == MOST_AT_ONCE:
            break
        for branch, _ in graph.hub(way[-1]).ends:
            for node in graph.ends(branch):
                if node not in seen:
                    seen.add(node)
                    waiting.append((*way, node))
    return None


def _joining(graph: LocalGraph, nodes: list[int]) -> list[int]:
    """Return a branch between each two nodes that follow one another."""
    return [
        next(branch for branch, _ in graph.hub(node).ends if after in graph.ends(branch))
        for node, after in pairwise(nodes)
    ]


def _way(graph: LocalGraph, node: int, branch: int) -> int:
    """Return the index of a branch among the ways of a node."""
    return next(i for i, (number, _) in enumerate(graph.hub(node).ends) if number == branch)
