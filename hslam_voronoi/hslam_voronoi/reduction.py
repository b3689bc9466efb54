"""The reduction of a graph of branches to the reduced GVG: spurs too short to count go, near meet points merge."""

import math
from collections.abc import Collection, Mapping
from types import MappingProxyType

import numpy as np

from hslam_types.se2 import Array
from hslam_voronoi.branch_graph import Branch, BranchGraph
from hslam_voronoi.rules import ReductionRules

MOST_ROUNDS = 50
"""Each round takes something away, so this is never reached; it bounds a defect."""
NOTHING_BEYOND: Mapping[int, float] = MappingProxyType({})


def reduce(
    graph: BranchGraph,
    rules: ReductionRules,
    beyond: Mapping[int, float] = NOTHING_BEYOND,
    unseen: Collection[int] = (),
) -> None:
    """Reduce ``graph`` in place; the nodes that are left with one branch are boundary points.

    Where only part of a floor is known, ``beyond`` tells by node how far (m) a branch that ends there may go on; one
    that ends at +inf is never taken for a spur.  One that ends in a node of ``unseen`` needs no more than the least
    extent of all, however wide the place is that it leaves: it may be long.
    """
    graph.collapse()
    for _ in range(MOST_ROUNDS):
        before = (len(graph.hubs), len(graph.branches))
        while _prune(graph, rules, beyond, unseen):
            graph.collapse()
        _merge(graph, rules)
        graph.collapse()
        if (len(graph.hubs), len(graph.branches)) == before:
            break


def spur_extent(path: Array, root_clearance: float) -> float:
    """Return how far a path (k x 3, from its root) reaches beyond the root: max of (way + clearance) - clearance."""
    steps = np.diff(path[:, :2], axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
    return float((way + path[:, 2]).max() - root_clearance)


def _prune(graph: BranchGraph, rules: ReductionRules, beyond: Mapping[int, float], unseen: Collection[int]) -> bool:
    """Remove every spur too short to count, all at once (one at a time runs boundary nodes into corners)."""
    failing: dict[int, list[tuple[float, int]]] = {}
    for number, branch in graph.branches.items():
        for end in (0, 1):
            root, leaf = branch.node(end), branch.node(1 - end)
            if graph.degree(leaf) != 1 or graph.degree(root) == 1:
                continue
            clearance = graph.hubs[root].clearance
            extent = spur_extent(branch.path_from(end), clearance) + beyond.get(leaf, 0.0)
            needed = min(rules.spur_ratio * clearance, clearance + rules.spur_beyond_m) if leaf not in unseen else 0.0
            if extent < max(rules.spur_least_m, needed):
                failing.setdefault(root, []).append((extent, number))
    for root, spurs in failing.items():
        spurs.sort()
        spare = graph.degree(root) - len(spurs)
        for _, number in spurs if spare > 0 else spurs[:-1]:
            graph.remove_branch(number)
    return bool(failing)


def _merge(graph: BranchGraph, rules: ReductionRules) -> None:
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


def _is_short(graph: BranchGraph, branch: Branch, rules: ReductionRules) -> bool:
    joins = all(graph.degree(end) >= 3 for end in (branch.u, branch.v))
    return branch.u != branch.v and joins and branch.length < rules.merge_ratio * _clearance(graph, branch)


def _clearance(graph: BranchGraph, branch: Branch) -> float:
    return max(graph.hubs[branch.u].clearance, graph.hubs[branch.v].clearance)


def _span(graph: BranchGraph, branch: Branch) -> float:
    """Return the widest distance (m) between the places that contracting a branch would make one."""
    members = graph.hubs[branch.u].members + graph.hubs[branch.v].members
    return max(math.dist(a, b) for i, a in enumerate(members) for b in members[i:])


def _drop_small_loops(graph: BranchGraph, number: int, rules: ReductionRules) -> None:
    hub = graph.hubs[number]
    for branch in sorted({branch for branch, _ in hub.ends}):
        is_loop = graph.branches[branch].u == graph.branches[branch].v
        if is_loop and graph.branches[branch].length <= rules.loop_ratio * hub.clearance and len(hub.ends) > 2:
            graph.remove_branch(branch)
