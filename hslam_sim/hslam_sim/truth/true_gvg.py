"""The true reduced GVG of a world, with the nodes that hold still under noise marked as core."""

import dataclasses
import math

import numpy as np

from hslam_sim.truth.gvg import TrueEdge, TrueGvg, TrueKind, TrueNode
from hslam_sim.truth.matching import match
from hslam_sim.truth.rules import Rules
from hslam_sim.truth.skeleton import reachable, wall_ridges, without_open_space
from hslam_sim.world import World
from hslam_voronoi.branch_graph import BranchGraph
from hslam_voronoi.chains import joined_chains
from hslam_voronoi.reduction import reduce

REACH_MARGIN_M = 0.06
NOISE_M = 0.02
"""Displacement of the walls in a variant: less than half a pixel of a usual map."""
NOISE_SEEDS = (1, 2, 3, 4)
CORE_SHARE = 0.8


def true_gvg(world: World, robot_radius: float = 0.19, rules: Rules | None = None) -> TrueGvg:
    """Return the reduced GVG a robot of ``robot_radius`` (m) can find in ``world``, core nodes marked."""
    if rules is None:
        rules = Rules(reach_m=robot_radius + REACH_MARGIN_M)
    exact = _NearWalls(world, rules, None)
    variants = [
        *(exact.under(variant) for variant in _varied(rules)),
        *(single_gvg(world, variant, None) for variant in _changed(rules, ("open_m", 0.15))),
        *(single_gvg(world, rules, seed) for seed in NOISE_SEEDS),
    ]
    return _with_core(exact.under(rules), variants)


def single_gvg(world: World, rules: Rules, noise_seed: int | None = None) -> TrueGvg:
    """Return the reduced GVG under one set of rules, every node core; a seed displaces the walls by noise."""
    return _NearWalls(world, rules, noise_seed).under(rules)


class _NearWalls:
    """The free space of a world but for its open places, and the ridges in it, which reductions share."""

    def __init__(self, world: World, rules: Rules, noise_seed: int | None) -> None:
        self._start = world.start.x, world.start.y
        self._space = without_open_space(world.free_space, rules.open_m)
        noise_m = 0.0 if noise_seed is None else NOISE_M
        rng = np.random.default_rng(0 if noise_seed is None else noise_seed)
        self._ridges = wall_ridges(self._space, rules, noise_m, rng)

    def under(self, rules: Rules) -> TrueGvg:
        """Return the reduced GVG of what a robot reaches; the ends left with one branch are boundary points."""
        raw = reachable(self._ridges, self._space, self._start, rules.reach_m)
        graph = joined_chains(raw.points, raw.links)
        reduce(graph, rules)
        return _value(graph)


def _varied(rules: Rules) -> list[Rules]:
    """Return the rules with one number changed at a time, of those that leave the ridges as they are."""
    return _changed(rules, ("spur_ratio", 0.3), ("merge_ratio", 0.3), ("reach_m", 0.15))


def _changed(rules: Rules, *changes: tuple[str, float]) -> list[Rules]:
    """Return the rules with one number changed at a time, by a share of it less and more."""
    return [
        dataclasses.replace(rules, **{name: getattr(rules, name) * (1.0 + sign * share)})
        for name, share in changes
        for sign in (-1.0, 1.0)
    ]


def _with_core(gvg: TrueGvg, variants: list[TrueGvg]) -> TrueGvg:
    """Return ``gvg`` with its core flags set and the nodes only variants have added."""
    hits = [0] * len(gvg.nodes)
    extra: list[TrueNode] = []
    for variant in variants:
        pairs = match(variant.nodes, gvg.nodes, [node.gate_m for node in gvg.nodes])
        for true in pairs.values():
            hits[true] += 1
        for index, node in enumerate(variant.nodes):
            if index not in pairs and not any(_same(node, other) for other in extra):
                extra.append(dataclasses.replace(node, core=False))
    nodes = tuple(
        dataclasses.replace(node, core=hit >= CORE_SHARE * len(variants))
        for node, hit in zip(gvg.nodes, hits, strict=True)
    )
    return TrueGvg(nodes, gvg.edges, tuple(extra))


def _same(a: TrueNode, b: TrueNode) -> bool:
    return a.is_boundary == b.is_boundary and math.dist((a.x, a.y), (b.x, b.y)) <= max(a.gate_m, b.gate_m)


def _value(graph: BranchGraph) -> TrueGvg:
    """Return the reduction's result as a value, without lone loops: no decision is made on them."""
    # Sorted by place, not by internal number: the numbering then survives small changes of the walls.
    kept = [n for n, hub in graph.hubs.items() if len(hub.ends) != 2]
    order = sorted(kept, key=lambda n: (graph.hubs[n].x, graph.hubs[n].y))
    index = {number: i for i, number in enumerate(order)}
    edges = [
        (number, TrueEdge(index[b.u], index[b.v], b.path[:, :2].copy(), b.length))
        for number, b in graph.branches.items()
        if b.u in index
    ]
    edges.sort(key=lambda item: (item[1].u, item[1].v, item[1].length_m))
    place = {number: i for i, (number, _) in enumerate(edges)}
    nodes = [_node(graph, number, place) for number in order]
    return TrueGvg(tuple(nodes), tuple(edge for _, edge in edges))


def _node(graph: BranchGraph, number: int, place: dict[int, int]) -> TrueNode:
    """Return one node; ``place`` gives the final index of each branch."""
    hub = graph.hubs[number]
    kind = TrueKind.BOUNDARY_POINT if len(hub.ends) == 1 else TrueKind.MEET_POINT
    return TrueNode(hub.x, hub.y, hub.clearance, kind, tuple((place[branch], end) for branch, end in hub.ends))
