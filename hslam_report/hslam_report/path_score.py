"""Edges compared as core paths: ways from one core node to the next with none in between.

Raw edges would punish a merged or split optional node twice.
"""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from hslam_report.explored import ExploredGraph
from hslam_sim.truth.gvg import TrueGvg

LENGTH_TOLERANCE_M = 2.0
LENGTH_TOLERANCE_SHARE = 0.2
MOST_STEPS = 8
"""Optional nodes on one path; bounds the search where many of them make a mesh."""

Ends = tuple[int, int]
Paths = dict[Ends, list[float]]
"""Lengths (m) of the paths between two core nodes, the smaller index first."""


@dataclass(frozen=True)
class PathScore:
    """How many core paths were found."""

    explored: int
    true: int
    matched: int

    @property
    def precision(self) -> float:
        """Matched of explored; 0 if none."""
        return self.matched / max(self.explored, 1)

    @property
    def recall(self) -> float:
        """Matched of true; 0 if none."""
        return self.matched / max(self.true, 1)


def compare_paths(graph: ExploredGraph, truth: TrueGvg, core: dict[int, int]) -> PathScore:
    """Return the score of an explored graph whose node ids ``core`` maps to true core nodes."""
    explored = core_paths([(edge.u, edge.v, edge.length_m) for edge in graph.edges], core)
    own = {index: index for index, node in enumerate(truth.nodes) if node.core}
    true = core_paths([(edge.u, edge.v, edge.length_m) for edge in truth.edges], own)
    matched = sum(_matched(explored[ends], true[ends]) for ends in explored if ends in true)
    return PathScore(sum(map(len, explored.values())), sum(map(len, true.values())), matched)


def core_paths(edges: list[tuple[int, int, float]], core: dict[int, int]) -> Paths:
    """Return the lengths of all simple paths between core nodes with no core node inside, under the core's numbers."""
    leaving: dict[int, list[tuple[int, int, float]]] = defaultdict(list)
    for number, (u, v, length) in enumerate(edges):
        leaving[u].append((number, v, length))
        leaving[v].append((number, u, length))
    seen: dict[frozenset[int], tuple[Ends, float]] = {}
    for first, name in core.items():
        stack: list[tuple[int, float, tuple[int, ...], frozenset[int]]] = [(first, 0.0, (), frozenset())]
        while stack:
            at, length, used, inside = stack.pop()
            for number, to, step in leaving[at]:
                if number in used or to in inside:
                    continue
                way = (*used, number)
                if to in core:
                    low, high = sorted((name, core[to]))
                    # A path is found from both its ends; its set of edges tells that it is one.
                    seen.setdefault(frozenset(way), ((low, high), length + step))
                elif len(way) < MOST_STEPS:
                    stack.append((to, length + step, way, inside | {to}))
    paths: Paths = defaultdict(list)
    for ends, length in seen.values():
        paths[ends].append(length)
    return paths


def _matched(explored: list[float], true: list[float]) -> int:
    """Return the largest number of one-to-one pairs whose lengths agree."""
    gap = np.abs(np.subtract.outer(np.array(explored), np.array(true)))
    fits = gap <= np.maximum(LENGTH_TOLERANCE_M, LENGTH_TOLERANCE_SHARE * np.array(true))
    rows, columns = linear_sum_assignment(~fits)
    return int(fits[rows, columns].sum())
