"""The local Voronoi graph: the dual of the Delaunay triangles of the obstacle points, where the robot can pass.

A triangle's circumcentre is equidistant from three points; two triangles that share a side are joined by a ridge
of points equidistant from that side's ends.  Ridges through gaps too narrow for the robot are dropped, so what
is left round the robot is the GVG of the obstacles, with unknown space open.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import Delaunay

from hslam_types.se2 import Array

Indices = npt.NDArray[np.signedinteger[Any]]

CELL_M = 0.1
"""Points closer together than about this are averaged."""
SITES = 1.25
"""Points out to this multiple of the horizon shape the graph within it."""
FAR = 3.0
"""A ring of far points at this multiple of the horizon closes the triangulation; its ridges lie beyond the horizon."""
FAR_COUNT = 24
"""Points of that ring; so many keep its ridges beyond the horizon."""


class VoronoiGraph(NamedTuple):
    """Vertices within the horizon, and ridges between them; a ridge that leaves the horizon ends in an exit."""

    position: list[tuple[float, float]]
    """Metres, in the points' frame."""
    clearance: list[float]
    """Distance from each vertex to its obstacles (m)."""
    neighbours: list[list[int]]
    exits: set[int]
    """Vertices beyond the horizon, one for each ridge that leads there."""
    passage: dict[tuple[int, int], float]
    """Least clearance along each ridge (m), by its vertices in either order."""


def voronoi_graph(points: Array, x: float, y: float, horizon_m: float, gap_m: float) -> VoronoiGraph:
    """Return the connected part nearest to (x, y) of the Voronoi graph of ``points`` (n x 2, m), out to the horizon."""
    around = thinned(points, x, y, horizon_m * SITES)
    angles = np.arange(FAR_COUNT) * (2.0 * math.pi / FAR_COUNT)
    ring = FAR * horizon_m * np.column_stack((np.cos(angles), np.sin(angles)))
    sites = np.concatenate((around, ring))
    mesh = Delaunay(sites)
    triangles, centre, radius = mesh.simplices, *circumcircles(sites[mesh.simplices])
    first, second, side = ridges(triangles, mesh.neighbors)
    clear, length = ridge_clearance(sites[side[:, 0]], sites[side[:, 1]], centre[first], centre[second])
    # Ends of a short side are one obstacle, unless they are seen far apart (a corner).
    kept = (clear >= 0.5 * gap_m) & (length >= np.minimum(gap_m, clear))
    inside = np.einsum("ij,ij->i", centre, centre) < horizon_m * horizon_m
    kept &= inside[first] | inside[second]
    return _component(first[kept], second[kept], clear[kept], centre, radius, inside, (x, y))


def thinned(points: Array, x: float, y: float, reach_m: float) -> Array:
    """Return the points within reach, relative to (x, y), averaged over small cells (fixed in the points' frame)."""
    near = points[(np.abs(points[:, 0] - x) < reach_m) & (np.abs(points[:, 1] - y) < reach_m)]
    cell = np.floor(near / CELL_M).astype(np.int64)
    key = cell[:, 0] * 1_000_003 + cell[:, 1]
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    mean_x = np.bincount(which, near[:, 0]) / count - x
    mean_y = np.bincount(which, near[:, 1]) / count - y
    return np.column_stack((mean_x, mean_y))


def circumcircles(corners: Array) -> tuple[Array, Array]:
    """Return circumcentres (t x 2) and radii (t) of triangles (t x 3 x 2)."""
    a = corners[:, 0]
    b, c = corners[:, 1] - a, corners[:, 2] - a
    double = 2.0 * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    double = np.where(np.abs(double) < 1e-12, 1e-12, double)
    bb, cc = np.einsum("ij,ij->i", b, b), np.einsum("ij,ij->i", c, c)
    ux = (c[:, 1] * bb - b[:, 1] * cc) / double
    uy = (b[:, 0] * cc - c[:, 0] * bb) / double
    return a + np.column_stack((ux, uy)), np.sqrt(ux * ux + uy * uy)


def ridges(triangles: Indices, neighbours: Indices) -> tuple[Indices, Indices, Indices]:
    """Return each pair of neighbouring triangles once, and the two sites of their common side (m x 2)."""
    count = len(triangles)
    first = np.repeat(np.arange(count), 3)
    second = neighbours.ravel()
    once = second > first
    side = np.stack((triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]), axis=1).reshape(-1, 2)
    return first[once], second[once], side[once]


def ridge_clearance(a: Array, b: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """Return the least distance to the sites a and b along each ridge from start to end, and |a - b| (m)."""
    middle, across = 0.5 * (a + b), b - a
    length = np.sqrt(np.einsum("ij,ij->i", across, across))
    normal = np.column_stack((-across[:, 1], across[:, 0])) / length[:, None]
    s = np.einsum("ij,ij->i", start - middle, normal)
    t = np.einsum("ij,ij->i", end - middle, normal)
    nearest = np.where(s * t < 0.0, 0.0, np.minimum(np.abs(s), np.abs(t)))
    return np.sqrt(nearest * nearest + 0.25 * length * length), length


def _component(
    first: Indices,
    second: Indices,
    clear: Array,
    centre: Array,
    radius: Array,
    inside: npt.NDArray[np.bool_],
    origin: tuple[float, float],
) -> VoronoiGraph:
    if not len(first):
        return VoronoiGraph([], [], [], set(), {})
    a, b = centre[first], centre[second]
    along = b - a
    share = np.clip(-np.einsum("ij,ij->i", a, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-12), 0.0, 1.0)
    foot = a + share[:, None] * along
    nearest = int(np.argmin(np.einsum("ij,ij->i", foot, foot)))
    links: dict[int, list[tuple[int, float]]] = {}
    pairs = list(zip(first.tolist(), second.tolist(), strict=True))
    within = inside.tolist()
    for (u, v), room in zip(pairs, clear.tolist(), strict=True):
        links.setdefault(u, []).append((v, room))
        links.setdefault(v, []).append((u, room))
    start = pairs[nearest][0] if within[pairs[nearest][0]] else pairs[nearest][1]
    number = {start: 0}
    members, exits = [start], set[int]()
    neighbours: list[list[int]] = [[]]
    passage: dict[tuple[int, int], float] = {}
    at = 0
    while at < len(members):
        if at not in exits:
            for v, room in links[members[at]]:
                other = number.get(v, len(members))
                if other == len(members):
                    members.append(v)
                    neighbours.append([])
                    if within[v]:
                        number[v] = other
                    else:
                        # Each ridge that leaves the horizon gets an exit of its own.
                        exits.add(other)
                        neighbours[other].append(at)
                neighbours[at].append(other)
                passage[at, other] = passage[other, at] = room
        at += 1
    rows = np.array(members)
    position = [(px + origin[0], py + origin[1]) for px, py in centre[rows].tolist()]
    return VoronoiGraph(position, radius[rows].tolist(), neighbours, exits, passage)
