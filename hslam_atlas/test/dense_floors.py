"""Floors whose places are hard to tell apart: short edges, rooms side by side, ways of one length, identical wings."""

from itertools import pairwise
from typing import TypeAlias

import networkx as nx
import numpy as np
from corridor_floor import Corridor, Point

Plan: TypeAlias = "nx.MultiGraph[Point]"


def office(doors: int, rng: np.random.Generator) -> tuple[Corridor, ...]:
    """Return a corridor with doors 1 to 4 m apart, rooms behind them, and doors between some of the rooms."""
    at = np.cumsum(rng.uniform(1.0, 4.0, doors + 1)).tolist()
    plan: Plan = nx.MultiGraph()
    spine: list[Point] = [(0.0, 0.0)]
    last: dict[float, Point] = {}
    for k, x in enumerate(at[:-1]):
        spine.append((x, 0.0))
        for side in rng.permutation([-1.0, 1.0])[: 1 + int(rng.random() < 0.3)].tolist():
            room = (x, side * rng.uniform(1.2, 4.0))
            _lay(plan, (x, 0.0), room)
            if side in last and rng.random() < 0.35:
                _lay(plan, last[side], (last[side][0], room[1]), room)
            last[side] = room
        if k % 5 == 4:
            last.clear()
    spine.append((at[-1], 0.0))
    for a, b in pairwise(spine):
        _lay(plan, a, b)
    return _corridors(plan, 1.4)


def theta(half_m: float, depth_m: float, skew_m: float, width: float = 2.4) -> tuple[Corridor, ...]:
    """Return two nodes joined by a middle way and two outer ones; one reaches ``skew_m`` farther out."""
    west, east = (0.0, 0.0), (2.0 * half_m, 0.0)
    above, below = depth_m, -depth_m - skew_m
    lines = (
        (west, east),
        (west, (0.0, above), (2.0 * half_m, above), east),
        (west, (0.0, below), (2.0 * half_m, below), east),
    )
    return tuple(Corridor(0, 1, line, width) for line in lines)


def ring(spurs: int, pitch_m: float, depth_m: float) -> tuple[Corridor, ...]:
    """Return a square loop with dead ends outwards, one as the other and ``pitch_m`` apart."""
    side = max(1, spurs // 4)
    length = (side + 1) * pitch_m
    plan: Plan = nx.MultiGraph()
    corners = ((0.0, 0.0), (length, 0.0), (length, length), (0.0, length))
    outward = ((0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))
    round_it: list[Point] = []
    for (x, y), (to_x, to_y), (ox, oy) in zip(corners, (*corners[1:], corners[0]), outward, strict=True):
        round_it.append((x, y))
        for k in range(side):
            share = (k + 1) * pitch_m / length
            place = (x + share * (to_x - x), y + share * (to_y - y))
            round_it.append(place)
            _lay(plan, place, (place[0] + ox * depth_m, place[1] + oy * depth_m))
    for a, b in pairwise((*round_it, round_it[0])):
        _lay(plan, a, b)
    return _corridors(plan, 2.0)


def wings(rooms: int, pitch_m: float, apart_m: float) -> tuple[Corridor, ...]:
    """Return a corridor that joins two wings of one shape."""
    plan: Plan = nx.MultiGraph()
    for left in (0.0, apart_m):
        places: list[Point] = [(left, (k + 1) * pitch_m) for k in range(rooms)]
        for a, b in pairwise(((left, 0.0), *places)):
            _lay(plan, a, b)
        for x, y in places:
            _lay(plan, (x, y), (x + 4.0, y))
        _lay(plan, (left, 0.0), (left, -4.0))
    _lay(plan, (0.0, 0.0), (apart_m, 0.0))
    return _corridors(plan, 1.6)


def tree(nodes: int, rng: np.random.Generator) -> tuple[Corridor, ...]:
    """Return ways of a lattice with 6 m cells without any loop."""
    lattice = nx.grid_2d_graph(6, 6)
    for edge in lattice.edges:
        lattice.edges[edge]["weight"] = rng.random()
    whole = nx.minimum_spanning_tree(lattice)
    plan: Plan = nx.MultiGraph()
    for count, (a, b) in enumerate(nx.bfs_edges(whole, (0, 0))):
        if count == nodes:
            break
        _lay(plan, (6.0 * a[0], 6.0 * a[1]), (6.0 * b[0], 6.0 * b[1]))
    return _corridors(plan, 2.0)


def _lay(plan: Plan, *line: Point) -> None:
    """Lay a way along a line of points."""
    for a, b in pairwise(line):
        plan.add_edge(a, b)


def _corridors(plan: Plan, width: float) -> tuple[Corridor, ...]:
    """Return the plan's ways with the points taken out that only two ways meet at: those are bends."""
    ends = [place for place in plan if plan.degree(place) != 2]
    number = {place: k for k, place in enumerate(sorted(ends))}
    corridors: list[Corridor] = []
    walked: set[tuple[frozenset[Point], int]] = set()
    for start in sorted(ends):
        for _, there, key in sorted(plan.edges(start, keys=True)):
            line: list[Point] = [start]
            here, onward, by = start, there, key
            if (frozenset((here, onward)), by) in walked:
                continue
            while True:
                walked.add((frozenset((here, onward)), by))
                line.append(onward)
                if onward in number:
                    break
                ((here, onward, by),) = (
                    (onward, far, k)
                    for _, far, k in plan.edges(onward, keys=True)
                    if (frozenset((onward, far)), k) not in walked
                )
            corridors.append(Corridor(number[start], number[line[-1]], tuple(line), width))
    return tuple(corridors)
