"""Random places of a floor that a robot on its graph can get to, and how far one truly is from another."""

import math
from typing import Any

import numpy as np
import scipy.sparse as sp
import shapely
from scipy.sparse import csgraph

from hslam_bringup.errors import RunError
from hslam_sim.truth.true_gvg import true_gvg
from hslam_sim.world import World
from hslam_types.se2 import SE2

_ROOM_M = 0.35
"""Clearance of every place drawn: the body's radius and what it keeps from walls."""
_CELLS = 150_000
_LEAST_CELL_M = 0.1
_MOVES = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))


def random_places(world: World, count: int, rng: np.random.Generator) -> list[SE2]:
    """Return poses in the world (m, rad), each nearer to some place of the true reduced GVG than any wall is."""
    edges = true_gvg(world).edges
    if not edges:
        raise RunError(f"the GVG of {world.name} has no edges: there is nowhere to go")
    lengths = np.array([edge.length_m for edge in edges])
    places: list[SE2] = []
    while len(places) < count:
        polyline = edges[int(rng.choice(len(edges), p=lengths / lengths.sum()))].polyline
        x, y = polyline[int(rng.integers(len(polyline)))].tolist()
        reach = world.clearance(x, y) - _ROOM_M
        angle, share, heading = rng.uniform((-math.pi, 0.0, -math.pi), (math.pi, 1.0, math.pi)).tolist()
        if reach > 0.0:
            away = reach * math.sqrt(share)
            places.append(SE2(x + away * math.cos(angle), y + away * math.sin(angle), heading))
    return places


class ShortestWays:
    """The length of the shortest way of a round body between two places, on a grid with 16 directions (3 % long)."""

    def __init__(self, world: World, body_radius_m: float) -> None:
        """Lay a grid over the free space."""
        free = world.free_space.buffer(-body_radius_m)
        x0, y0, x1, y1 = free.bounds
        self._cell_m = max(_LEAST_CELL_M, math.sqrt((x1 - x0) * (y1 - y0) / _CELLS))
        self._origin = np.array([x0, y0])
        self._shape = int((x1 - x0) / self._cell_m) + 1, int((y1 - y0) / self._cell_m) + 1
        columns, rows = np.meshgrid(*(np.arange(n) for n in self._shape), indexing="ij")
        shapely.prepare(free)
        self._free = shapely.contains_xy(free, x0 + columns * self._cell_m, y0 + rows * self._cell_m)
        self._places = np.argwhere(self._free)
        self._graph = self._moves()

    def length_m(self, a: SE2, b: SE2) -> float:
        """Return how far it is from a to b; infinite where no way leads."""
        shortest: Any = csgraph.dijkstra  # its stubs know no sparse array
        found = shortest(self._graph, directed=False, indices=self._nearest(a))
        return max(float(found[self._nearest(b)]), math.dist(a[:2], b[:2]))

    def _nearest(self, place: SE2) -> int:
        """Return the index of the free cell nearest to a place."""
        at = (np.array(place[:2]) - self._origin) / self._cell_m
        i, j = np.round(at).astype(int).tolist()
        i, j = min(max(i, 0), self._shape[0] - 1), min(max(j, 0), self._shape[1] - 1)
        if not self._free[i, j]:
            i, j = self._places[int(np.argmin(((self._places - at) ** 2).sum(axis=1)))].tolist()
        return int(i) * self._shape[1] + int(j)

    def _moves(self) -> sp.csr_array:
        width, height = self._shape
        number = np.arange(width * height).reshape(self._shape)
        starts, stops, lengths = [], [], []
        for di, dj in _MOVES:
            a = (slice(0, width - di), slice(max(0, -dj), height - max(0, dj)))
            b = (slice(di, width), slice(max(0, dj), height - max(0, -dj)))
            both = self._free[a] & self._free[b]
            starts.append(number[a][both])
            stops.append(number[b][both])
            lengths.append(np.full(int(both.sum()), self._cell_m * math.hypot(di, dj)))
        entries = np.concatenate(lengths), (np.concatenate(starts), np.concatenate(stops))
        return sp.csr_array(entries, shape=(width * height, width * height))
