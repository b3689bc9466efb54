"""The GVG of a polygon, as ridges of the Voronoi diagram of points sampled along its walls.

A ridge belongs to the GVG if the two wall points it separates lie on different outlines, or apart along
one outline; and if a robot fits on all of it.  Source of the Voronoi diagram: Qhull (scipy.spatial).
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Voronoi

from hslam_sim.truth.rules import Rules
from hslam_types.se2 import Array

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Skeleton:
    """All points equidistant from two walls, before any of it is judged."""

    points: Array
    """x, y and clearance (m, in map), n x 3."""
    links: Indices
    """Pairs of neighbouring points, m x 2."""


@dataclass(frozen=True, eq=False)
class Ridges:
    """Every ridge between two walls, whether a robot fits there or not."""

    vertices: Array
    """x, y and clearance (m, in map), n x 3."""
    ends: Indices
    """The two vertices of each ridge, m x 2."""


def without_open_space(free_space: shapely.Polygon, open_m: float) -> shapely.Geometry:
    """Return the free space but for what is farther than ``open_m`` from every wall: a polygon, or several."""
    return free_space.difference(free_space.buffer(-open_m))


def wall_ridges(near_walls: shapely.Geometry, rules: Rules, noise_m: float, rng: np.random.Generator) -> Ridges:
    """Return the ridges between the outlines of ``near_walls``, their samples displaced by ``noise_m`` (std)."""
    outlines = [ring for part in shapely.get_parts(near_walls) for ring in (part.exterior, *part.interiors)]
    rings = [_sampled(np.asarray(ring.coords), rules.sample_m) for ring in outlines]
    if noise_m > 0.0:
        rings = [_jittered(ring, noise_m, rng) for ring in rings]
    sites = np.concatenate(rings)
    diagram = Voronoi(sites)
    generators = np.asarray(diagram.ridge_points, dtype=np.int64)
    # Unbounded ridges have an end numbered -1; they all lie outside.
    ends = np.array([pair if len(pair) == 2 else (-1, -1) for pair in diagram.ridge_vertices], dtype=np.int64)
    chosen = (ends >= 0).all(axis=1) & _separates_walls(generators, rings, sites, rules.bend_m)
    generators, ends = generators[chosen], ends[chosen]
    places = np.asarray(diagram.vertices, dtype=np.float64)
    clearance = np.zeros(len(places))
    for side in (0, 1):
        clearance[ends[:, side]] = np.hypot(*(places[ends[:, side]] - sites[generators[:, 0]]).T)
    used, renumbered = np.unique(ends, return_inverse=True)
    return Ridges(np.column_stack([places[used], clearance[used]]), renumbered.reshape(-1, 2).astype(np.int64))


def reachable(ridges: Ridges, near_walls: shapely.Geometry, start: tuple[float, float], reach_m: float) -> Skeleton:
    """Return the ridges a disc of radius ``reach_m`` gets to from ``start`` (in map), the largest connected part.

    The GVG alone need not be connected, but a robot that follows it finds one part; and fragments hang about
    the corners of pilasters where the wall samples are noisy.
    """
    reach = _reach(near_walls, start, reach_m)
    usable = shapely.contains_xy(reach, ridges.vertices[:, 0], ridges.vertices[:, 1])
    ends = ridges.ends[usable[ridges.ends].all(axis=1)]
    kept, links = np.unique(_largest_part(ends, len(ridges.vertices)), return_inverse=True)
    return Skeleton(ridges.vertices[kept], links.reshape(-1, 2).astype(np.int64))


def _largest_part(ends: Indices, count: int) -> Indices:
    """Return the links of the connected component that has the most of them."""
    if len(ends) == 0:
        return ends
    linked = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    part = connected_components(linked, directed=False)[1][ends[:, 0]]
    largest: Indices = ends[part == np.argmax(np.bincount(part))]
    return largest


def _reach(near_walls: shapely.Geometry, start: tuple[float, float], reach: float) -> shapely.Geometry:
    """Return the part with ``reach`` clearance nearest to the start."""
    parts = shapely.get_parts(shapely.buffer(near_walls, -reach))
    if len(parts) == 0:
        return shapely.Polygon()
    nearest: shapely.Geometry = parts[int(np.argmin(shapely.distance(parts, shapely.Point(start))))]
    shapely.prepare(nearest)
    return nearest


def _sampled(ring: Array, spacing: float) -> Array:
    """Return points along a closed ring at equal distances of at most ``spacing`` (m), corners not kept, n x 2."""
    steps = np.hypot(*np.diff(ring, axis=0).T)
    ends = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, ends[-1], max(int(np.ceil(ends[-1] / spacing)), 8), endpoint=False)
    return np.column_stack([np.interp(at, ends, ring[:, 0]), np.interp(at, ends, ring[:, 1])])


def _jittered(ring: Array, noise: float, rng: np.random.Generator) -> Array:
    """Return ring samples displaced by noise smoothed over five neighbours, as a fresh scan of the walls would."""
    displaced = ring + rng.normal(0.0, noise, ring.shape)
    smoothed: Array = sum((np.roll(displaced, shift, axis=0) for shift in (-2, -1, 1, 2)), displaced) / 5.0
    return smoothed


def _separates_walls(ridges: Indices, rings: list[Array], sites: Array, bend: float) -> npt.NDArray[np.bool_]:
    """Return which ridges lie between different outlines, or between parts of one outline that face each other."""
    owner = np.concatenate([np.full(len(ring), index) for index, ring in enumerate(rings)])
    step = np.concatenate([np.full(len(ring), _perimeter(ring) / len(ring)) for ring in rings])
    count = np.concatenate([np.full(len(ring), len(ring)) for ring in rings])
    first, second = ridges[:, 0], ridges[:, 1]
    # Samples of one ring are numbered in order, so their distance along it is a difference of numbers.
    apart = np.abs(first - second)
    along = np.minimum(apart, count[first] - apart) * step[first]
    chord = np.hypot(*(sites[first] - sites[second]).T)
    separates: npt.NDArray[np.bool_] = (owner[first] != owner[second]) | (along - chord > bend)
    return separates


def _perimeter(ring: Array) -> float:
    return float(np.hypot(*(ring - np.roll(ring, 1, axis=0)).T).sum())
