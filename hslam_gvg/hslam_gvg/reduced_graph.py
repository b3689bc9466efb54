"""From the local Voronoi graph to the reduced GVG: which nodes and branches count.

The rules are those of the true graph the suite is scored against: a dead end is an edge only if it leads
somewhere (rule 5), meet points nearer to each other than their clearance are one (rule 6), and points with two
edges are none.  Unknown space counts as leading on: an exit is never pruned.
"""

import math
from itertools import pairwise
from typing import NamedTuple

from hslam_gvg.voronoi_graph import VoronoiGraph
from hslam_types.se2 import wrap

PARALLEL_LOOP = 3.2
"""A loop shorter than this multiple of the clearance is an artefact."""
ROUNDS = 6
"""Merging makes new dead ends and pruning new chains; bounds how often both are repeated."""
ONE_WAY, NEARLY_ONE, SQUEEZE = math.radians(60.0), math.radians(80.0), 0.6
PASSAGE_M = 2.5
"""Branches that leave closer together than this pass one obstacle on both sides, most often an echo in mid-air."""


class ReducedNode(NamedTuple):
    """A strong meet point (three bearings or more) or a boundary point (one), in the frame of the obstacle points."""

    x: float
    y: float
    clearance_m: float
    bearings: tuple[float, ...]
    """Direction of each edge by its chord (rad), counter-clockwise from -pi."""

    @property
    def degree(self) -> int:
        """The number of edges."""
        return len(self.bearings)


Links = dict[int, list[int]]


class ReducedGraph:
    """The reduced GVG round one place."""

    def __init__(self, graph: VoronoiGraph, dead_end_m: float, chord_m: float) -> None:
        """Reduce a local Voronoi graph; bearings are taken at ``chord_m`` from the node."""
        graph = graph._replace(passage=dict(graph.passage))
        self._graph, self._chord_m = graph, chord_m
        self._links: Links = {u: list(around) for u, around in enumerate(graph.neighbours)}
        for _ in range(ROUNDS):
            changed = _prune(graph, self._links, dead_end_m)
            changed |= _merge(graph, self._links)
            if not changed:
                break
        found = [
            self._node(u) for u, around in self._links.items() if u not in graph.exits and len(around) not in (0, 2)
        ]
        self.nodes = [node for node in found if node.degree != 2]
        """Strong meet points and boundary points."""

    def node_near(self, x: float, y: float, within_m: float) -> ReducedNode | None:
        """Return the node nearest to a place, if one is within ``within_m``."""
        near = min(self.nodes, key=lambda node: math.hypot(node.x - x, node.y - y), default=None)
        return near if near is not None and math.hypot(near.x - x, near.y - y) <= within_m else None

    def passing(self, x: float, y: float) -> tuple[float, ...]:
        """Return the directions (rad) in which the graph leads on from its vertex nearest to a place."""
        inner = [u for u in self._links if u not in self._graph.exits]
        if not inner:
            return ()
        nearest = min(inner, key=lambda u: math.dist(self._graph.position[u], (x, y)))
        return self._node(nearest).bearings

    def _node(self, u: int) -> ReducedNode:
        graph, links = self._graph, self._links
        branches = [
            Branch(_chord(graph, links, u, v, self._chord_m), _passage(graph, _chain(links, u, v), PASSAGE_M))
            for v in links[u]
        ]
        return ReducedNode(*graph.position[u], graph.clearance[u], distinct(branches))


class Branch(NamedTuple):
    """One way out of a vertex."""

    bearing: float
    passage_m: float
    """Least clearance near the vertex."""


def distinct(branches: list[Branch]) -> tuple[float, ...]:
    """Return the directions of branches (rad, sorted), those that leave through one opening as one.

    Branches closer together than `ONE_WAY` are one; up to `NEARLY_ONE` they are if one of them squeezes through a
    gap much narrower than the other's: most often a hole in what is known of a wall.
    """
    left = sorted(branches)
    while len(left) > 1:
        pairs = zip(left, left[1:] + left[:1], strict=True)
        angle, first, second = min((wrap(b.bearing - a.bearing) % (2.0 * math.pi), a, b) for a, b in pairs)
        narrow, wide = sorted((first, second), key=lambda branch: branch.passage_m)
        squeezes = narrow.passage_m < SQUEEZE * wide.passage_m
        if angle >= (NEARLY_ONE if squeezes else ONE_WAY):
            break
        left.remove(first)
        left.remove(second)
        middle = wrap(first.bearing + 0.5 * angle)
        left = sorted([*left, wide if squeezes else Branch(middle, wide.passage_m)])
    return tuple(branch.bearing for branch in left)


def _passage(graph: VoronoiGraph, chain: list[int], length_m: float) -> float:
    """Return the least clearance along the first metres of a chain."""
    least, total = graph.clearance[chain[0]], 0.0
    for u, v in pairwise(chain):
        if total > length_m:
            break
        least = min(least, graph.passage.get((u, v), math.inf))
        total += math.dist(graph.position[u], graph.position[v])
    return least


def _chain(links: Links, start: int, towards: int) -> list[int]:
    """Return the vertices from ``start`` along one of its links to the next vertex that is no mere pass."""
    chain = [start, towards]
    while len(links[chain[-1]]) == 2 and chain[-1] != start:
        a, b = links[chain[-1]]
        chain.append(b if a == chain[-2] else a)
    return chain


def _lengths(graph: VoronoiGraph, chain: list[int]) -> list[float]:
    """Return the path length from the chain's first vertex to each of its vertices (m)."""
    total, lengths = 0.0, [0.0]
    for u, v in pairwise(chain):
        total += math.dist(graph.position[u], graph.position[v])
        lengths.append(total)
    return lengths


def _remove(links: Links, chain: list[int]) -> None:
    """Take a chain out, except its first vertex (and its last, if other chains meet there)."""
    for u, v in pairwise(chain):
        links[u].remove(v)
        links[v].remove(u)
    for u in chain[1:]:
        if u in links and not links[u]:
            del links[u]


def _prune(graph: VoronoiGraph, links: Links, dead_end_m: float) -> bool:
    """Rule 5: in batches, remove the dead ends that lead nowhere; every node keeps an edge."""
    changed = False
    while True:
        failing: dict[int, list[tuple[float, list[int]]]] = {}
        for leaf in [u for u, around in links.items() if len(around) == 1 and u not in graph.exits]:
            chain = _chain(links, leaf, links[leaf][0])[::-1]
            meet = chain[0]
            if len(links[meet]) < 3:
                continue
            d = graph.clearance[meet]
            reach = max(s + graph.clearance[u] for s, u in zip(_lengths(graph, chain), chain, strict=True)) - d
            if reach < max(dead_end_m, min(1.5 * d, d + 1.0)):
                failing.setdefault(meet, []).append((reach, chain))
        if not failing:
            return changed
        changed = True
        for meet, chains in failing.items():
            chains.sort(key=lambda entry: entry[0])
            for _, chain in chains[: len(links[meet]) - 1]:
                _remove(links, chain)


def _merge(graph: VoronoiGraph, links: Links) -> bool:
    """Rule 6: contract edges shorter than the clearance of their ends, shortest first, onto the roomier end."""
    changed = False
    while True:
        best: tuple[float, list[int]] | None = None
        for u, around in links.items():
            if len(around) < 3:
                continue
            for v in around:
                chain = _chain(links, u, v)
                length = _lengths(graph, chain)[-1]
                last = chain[-1]
                if last in graph.exits or len(links[last]) < 3:
                    continue
                room = max(graph.clearance[u], graph.clearance[last])
                limit = PARALLEL_LOOP * room if last == u else room
                if length < limit and (best is None or length < best[0]):
                    best = length, chain
        if best is None:
            return changed
        changed = True
        _contract(graph, links, best[1])


def _contract(graph: VoronoiGraph, links: Links, chain: list[int]) -> None:
    kept, gone = chain[0], chain[-1]
    if kept == gone:
        _remove(links, chain)
        return
    if graph.clearance[gone] > graph.clearance[kept]:
        chain.reverse()
        kept, gone = gone, kept
    _remove(links, chain)
    for v in links.pop(gone, []):
        links[v][links[v].index(gone)] = kept
        links[kept].append(v)
        if (gone, v) in graph.passage:
            graph.passage[kept, v] = graph.passage[v, kept] = graph.passage[gone, v]


def _chord(graph: VoronoiGraph, links: Links, start: int, towards: int, chord_m: float) -> float:
    """Return the direction from a node to the point where its branch leaves a circle of radius ``chord_m``."""
    x0, y0 = graph.position[start]
    last = (0.0, 0.0)
    for u in _chain(links, start, towards)[1:]:
        x, y = graph.position[u]
        here = (x - x0, y - y0)
        if math.hypot(*here) >= chord_m:
            return math.atan2(*_on_circle(last, here, chord_m)[::-1])
        last = here
    return math.atan2(last[1], last[0])


def _on_circle(inside: tuple[float, float], outside: tuple[float, float], radius: float) -> tuple[float, float]:
    """Return where a segment from within leaves the circle round the origin."""
    dx, dy = outside[0] - inside[0], outside[1] - inside[1]
    a, b = dx * dx + dy * dy, inside[0] * dx + inside[1] * dy
    c = inside[0] * inside[0] + inside[1] * inside[1] - radius * radius
    share = (-b + math.sqrt(max(b * b - a * c, 0.0))) / max(a, 1e-12)
    return inside[0] + share * dx, inside[1] + share * dy
