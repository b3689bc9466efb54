"""Where in an atlas one look at landmarks was taken, by their places alone: nothing is known of where the robot is.

Two landmarks far apart in the look are laid on every two of an edge-map as far apart; what fits the most of the others
is the place.  One look from a corridor may fit elsewhere, too: then there is no answer.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from hslam_atlas.edge_maps import EdgeMaps
from hslam_types.se2 import SE2, Array, rotation

_FEWEST = 5
"""Landmarks that make a place: two fix a pose, two more are shared by chance now and then."""
_SHARE = 0.7
"""Of the landmarks in sight that must be on the map."""
_LEAD = 3
"""By so many landmarks the best place must lead any other."""
_APART_M, _APART = 1.0, math.radians(20.0)
"""Two poses that differ by more are two places."""
_PAIRS = 6
"""Pairs of the look that are tried: the ones farthest apart."""


@dataclass(frozen=True, slots=True)
class SightedPlace:
    """A place a look may have been taken at."""

    edge: int
    base_in_edge: SE2
    """Pose of base_link in the edge's frame."""
    matched: int
    """Landmarks of the look that the edge's map has."""


def places_of(look: Array, edges: Iterable[int], maps: EdgeMaps, gate_m: float) -> list[SightedPlace]:
    """Return the places in edges that a look (n x 2, m, in base_link) fits, by each edge the best of each place.

    ``gate_m``: how far a landmark may lie from where the map has it.
    """
    found = []
    for edge in edges:
        landmarks = maps.get(edge).landmarks
        if len(landmarks) >= _FEWEST and len(look) >= _FEWEST:
            found += _on_edge(look, edge, landmarks, gate_m)
    return sorted(found, key=lambda place: (-place.matched, place.edge))


def beyond_doubt(places: list[SightedPlace], frames: Mapping[int, SE2], in_sight: int) -> SightedPlace | None:
    """Return the best place if none that lies elsewhere is nearly as good; None else.

    ``frames``: of the edges in a common picture, since landmarks about a node are in the maps of all its edges.
    """
    if not places or places[0].matched < max(_FEWEST, _SHARE * in_sight):
        return None
    best = places[0]
    here = frames[best.edge] @ best.base_in_edge
    for other in places[1:]:
        there = frames[other.edge] @ other.base_in_edge
        is_elsewhere = math.dist(here[:2], there[:2]) > _APART_M or abs(here.to(there).theta) > _APART
        if is_elsewhere and best.matched - other.matched < _LEAD:
            return None
    return best


def _on_edge(look: Array, edge: int, landmarks: Array, gate_m: float) -> list[SightedPlace]:
    pairs = np.column_stack(np.triu_indices(len(landmarks), 1))
    between = landmarks[pairs[:, 1]] - landmarks[pairs[:, 0]]
    lengths = np.hypot(*between.T)
    found: list[SightedPlace] = []
    for i, j in _farthest(look):
        across = look[j] - look[i]
        near = np.flatnonzero(np.abs(lengths - math.hypot(*across)) < gate_m)
        for n in near.tolist():
            for first, way in ((pairs[n, 0], between[n]), (pairs[n, 1], -between[n])):
                theta = math.atan2(way[1], way[0]) - math.atan2(across[1], across[0])
                x, y = (landmarks[first] - rotation(theta) @ look[i]).tolist()
                place = _settled(look, edge, SE2(x, y, theta), landmarks, gate_m)
                if place is not None and not any(_is_one(place, other) for other in found):
                    found.append(place)
    return found


def _farthest(look: Array) -> list[tuple[int, int]]:
    """Return the pairs of a look that lie farthest apart: they give the best heading."""
    i, j = np.triu_indices(len(look), 1)
    order = np.argsort(-np.hypot(*(look[j] - look[i]).T), kind="stable")[:_PAIRS]
    return list(zip(i[order].tolist(), j[order].tolist(), strict=True))


def _settled(look: Array, edge: int, pose: SE2, landmarks: Array, gate_m: float) -> SightedPlace | None:
    """Return the place near a pose that fits best, None if too few landmarks do."""
    count = 0
    for _ in range(2):
        apart = pose.apply_all(look)[:, None] - landmarks
        squared = (apart**2).sum(axis=2)
        index = squared.argmin(axis=1)
        fits = squared.min(axis=1) < gate_m**2
        count = len(set(index[fits].tolist()))
        if count < _FEWEST:
            return None
        pose = _best_fit(look[fits], landmarks[index[fits]])
    return SightedPlace(edge, pose, count)


def _is_one(place: SightedPlace, other: SightedPlace) -> bool:
    apart = place.base_in_edge.to(other.base_in_edge)
    return place.matched <= other.matched and math.hypot(apart.x, apart.y) < _APART_M and abs(apart.theta) < _APART


def _best_fit(points: Array, onto: Array) -> SE2:
    """Return the rigid motion that brings points onto others, by least squares (Arun et al., 1987)."""
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    theta = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    x, y = (onto.mean(axis=0) - rotation(theta) @ points.mean(axis=0)).tolist()
    return SE2(x, y, theta)
