"""From the raw skeleton to the reduced GVG: spurs go, near meet points merge, wide places become one node."""

import math

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hslam_sim.truth.branch_graph import Branch, BranchGraph
from hslam_sim.truth.rules import Rules
from hslam_sim.truth.skeleton import Indices, Skeleton
from hslam_types.se2 import Array

MOST_ROUNDS = 50
"""Each round takes something away, so this is never reached; it bounds a defect."""


def reduced(raw: Skeleton, rules: Rules) -> BranchGraph:
    """Return the reduced GVG of a skeleton; the ends that are left with one branch are boundary points."""
    graph = _branches(*_open_places_joined(raw, rules.open_m))
    graph.collapse()
    for _ in range(MOST_ROUNDS):
        before = (len(graph.hubs), len(graph.branches))
        while _prune(graph, rules):
            graph.collapse()
        _merge(graph, rules)
        graph.collapse()
        if (len(graph.hubs), len(graph.branches)) == before:
            break
    return graph


def _open_places_joined(raw: Skeleton, open_m: float) -> tuple[Array, Indices, set[int]]:
    """Return points, links and the points that stand for open places, each connected open part made one point.

    The branches of such a node begin at its contour of clearance ``open_m``, with that clearance.
    """
    inside = raw.points[:, 2] > open_m
    both = inside[raw.links].all(axis=1)
    n = len(raw.points)
    within = raw.links[both]
    joined = coo_matrix((np.ones(len(within)), (within[:, 0], within[:, 1])), shape=(n, n))
    _, labels = connected_components(joined, directed=False)
    centre = np.arange(n)
    points = raw.points.copy()
    for label in np.unique(labels[inside]):
        members = np.flatnonzero((labels == label) & inside)
        centre[members] = members[np.argmax(raw.points[members, 2])]
    points[inside, 2] = open_m
    links = centre[raw.links]
    return points, links[links[:, 0] != links[:, 1]], {int(c) for c in np.unique(centre[inside])}


def _branches(points: Array, links: Indices, open_places: set[int]) -> BranchGraph:
    """Return the graph whose branches are the chains between points of degree other than two."""
    neighbours: dict[int, list[int]] = {}
    for a, b in links.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    graph = BranchGraph()
    for number in sorted(neighbours):
        if len(neighbours[number]) != 2 or number in open_places:
            graph.add_hub(number, *points[number].tolist(), is_open=number in open_places)
    seen: set[tuple[int, int]] = set()
    for number in list(graph.hubs):
        for first in neighbours[number]:
            if (number, first) in seen:
                continue
            chain = [number, first]
            while chain[-1] not in graph.hubs:
                a, b = neighbours[chain[-1]]
                chain.append(b if a == chain[-2] else a)
            seen.add((chain[-1], chain[-2]))
            # An open place's branches are measured from its contour, so its centre is no part of the path.
            path = points[[p for p in chain if p not in open_places]] if len(chain) > 2 else points[chain]
            graph.add_branch(chain[0], chain[-1], path)
    graph.order_ends()
    return graph


def spur_extent(path: Array, root_clearance: float) -> float:
    """Return how far a path (k x 3, from its root) reaches beyond the root: max of (way + clearance) - clearance."""
    steps = np.diff(path[:, :2], axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
    return float((way + path[:, 2]).max() - root_clearance)


def _prune(graph: BranchGraph, rules: Rules) -> bool:
    """Remove every spur too short to count, all at once (one at a time runs boundary nodes into corners)."""
    failing: dict[int, list[tuple[float, int]]] = {}
    for number, branch in graph.branches.items():
        for end in (0, 1):
            root, leaf = branch.node(end), branch.node(1 - end)
            if graph.degree(leaf) != 1 or graph.degree(root) == 1:
                continue
            clearance = graph.hubs[root].clearance
            extent = spur_extent(branch.path_from(end), clearance)
            needed = min(rules.spur_ratio * clearance, clearance + rules.spur_beyond_m)
            if extent < max(rules.spur_least_m, needed):
                failing.setdefault(root, []).append((extent, number))
    for root, spurs in failing.items():
        spurs.sort()
        spare = graph.degree(root) - len(spurs)
        for _, number in spurs if spare > 0 else spurs[:-1]:
            graph.remove_branch(number)
    return bool(failing)


def _merge(graph: BranchGraph, rules: Rules) -> None:
    """Contract short edges between meet points, the shortest first, and drop the small loops that leaves."""
    refused: set[int] = set()
    while True:
        candidates = [
            (branch.length, number)
            for number, branch in graph.branches.items()
            if number not in refused and _is_short(graph, branch, rules)
        ]
        if not candidates:
            break
        number = min(candidates)[1]
        if _span(graph, graph.branches[number]) > rules.span_ratio * _clearance(graph, graph.branches[number]):
            refused.add(number)
            continue
        _drop_small_loops(graph, graph.contract(number), rules)
    for number in list(graph.hubs):
        if number in graph.hubs:
            _drop_small_loops(graph, number, rules)


def _is_short(graph: BranchGraph, branch: Branch, rules: Rules) -> bool:
    # Open places merge whatever their degree: a clearance that wavers about the limit makes a row of them.
    joins = all(graph.degree(end) >= 3 or graph.hubs[end].is_open for end in (branch.u, branch.v))
    return branch.u != branch.v and joins and branch.length < rules.merge_ratio * _clearance(graph, branch)


def _clearance(graph: BranchGraph, branch: Branch) -> float:
    return max(graph.hubs[branch.u].clearance, graph.hubs[branch.v].clearance)


def _span(graph: BranchGraph, branch: Branch) -> float:
    """Return the widest distance (m) between the places that contracting a branch would make one."""
    members = graph.hubs[branch.u].members + graph.hubs[branch.v].members
    return max(math.dist(a, b) for i, a in enumerate(members) for b in members[i:])


def _drop_small_loops(graph: BranchGraph, number: int, rules: Rules) -> None:
    hub = graph.hubs[number]
    for branch in sorted({branch for branch, _ in hub.ends}):
        is_loop = graph.branches[branch].u == graph.branches[branch].v
        if is_loop and graph.branches[branch].length <= rules.loop_ratio * hub.clearance and len(hub.ends) > 2:
            graph.remove_branch(branch)
