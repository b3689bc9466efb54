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
ONE_WAY = math.radians(60.0)
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
        graph = self._graph
        bearings = sorted(_chord(graph, self._links, u, v, self._chord_m) for v in self._links[u])
        return ReducedNode(*graph.position[u], graph.clearance[u], distinct(bearings))


def distinct(bearings: list[float]) -> tuple[float, ...]:
    """Return sorted directions (rad) with those closer together than `ONE_WAY` replaced by their mean."""
    merged = list(bearings)
    while len(merged) > 1:
        gaps = [
            (wrap(b - a) % (2.0 * math.pi), i)
            for i, (a, b) in enumerate(zip(merged, merged[1:] + merged[:1], strict=True))
        ]
        gap, i = min(gaps)
        if gap >= ONE_WAY:
            break
        both = wrap(merged[i] + 0.5 * gap)
        j = (i + 1) % len(merged)
        merged = sorted([b for k, b in enumerate(merged) if k not in (i, j)] + [both])
    return tuple(merged)


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
