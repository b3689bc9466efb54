"""How strongly two edge-maps speak for one place: whole edges, and the constellations of landmarks about a node.

A match rules candidates out; it proves nothing where places look alike (section III-B).  So the evidence is a
likelihood ratio against landmarks that merely stand along walls somewhere else, and whoever uses it caps it
by how often different places were seen to look the same.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hslam_atlas.alignment import Alignment, PointMap, align
from hslam_atlas.config import AtlasConfig
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2, Array

Indices = npt.NDArray[np.intp]

_FEWEST_PAIRS = 3
"""Two fix the offset and agree with anything."""
_CLEAR_FRACTION, _MANY_PAIRS = 0.7, 12
"""So many pairs match for themselves: different places were never seen to share more than half."""
_CHANCE_MOST = 0.5
"""No more of a landmark's absence is excused (nats): walls elsewhere need not even be in its place."""
_LEAST_SHOWN = 0.5
"""Two maps of one place share at least this much."""
_SIDE_ARMS_M = 6.0
"""Wall seen beyond an edge's two ends, counted when its density of landmarks is judged."""


@dataclass(frozen=True, slots=True, eq=False)
class MapMatch:
    """An alignment with its verdict."""

    alignment: Alignment
    evidence: float
    """Log-likelihood ratio of "the same place" against "somewhere else" (nats), not capped."""
    fraction: float
    """The lesser of the two fractions of landmarks that ought to be in the other map and are."""
    agrees: bool
    """Enough landmarks associate both ways and the map distance (eq. 8) is small."""


def match_edges(
    existing: EdgeMap,
    candidate: EdgeMap,
    prior: SE2,
    prior_covariance: Array,
    terminal_noise_m: float,
    config: AtlasConfig,
) -> MapMatch:
    """Match two maps of, maybe, one edge, both with their origins at, maybe, the same node.

    ``terminal_noise_m``: how far the far node may seem moved between two visits (standard deviation).
    """
    density = _density(existing, candidate)
    alignment = align(
        whole(existing),
        whole(candidate),
        prior,
        prior_covariance,
        density=density,
        pair_noise_m=config.pair_noise_m,
        terminal_noise_m=terminal_noise_m,
        gate=config.pair_gate,
    )
    return _judge(alignment, existing.size, candidate.size, density, config.visible_edge, config)


def match_constellations(
    existing: EdgeMap,
    candidate: EdgeMap,
    prior: SE2,
    prior_covariance: Array,
    config: AtlasConfig,
    within_m: float | None = None,
) -> MapMatch:
    """Match what two maps hold within a distance (``near_m`` if not given) of their origins, maybe the same node."""
    within_m = config.near_m if within_m is None else within_m
    near_e, near_c = near(existing, within_m + 1.0), near(candidate, within_m + 1.0)
    density = _density(existing, candidate)
    alignment = align(
        part(existing, near_e),
        part(candidate, near_c),
        prior,
        prior_covariance,
        density=density,
        pair_noise_m=config.pair_noise_m,
        terminal_noise_m=0.0,
        gate=config.pair_gate,
    )
    # A ring beyond may serve as partner but is not missed when it finds none.
    inner_e = set(np.flatnonzero(np.hypot(*existing.landmarks[near_e].T) < within_m).tolist())
    inner_c = set(np.flatnonzero(np.hypot(*candidate.landmarks[near_c].T) < within_m).tolist())
    expected_e = len(inner_e | {i for i, _ in alignment.pairs})
    expected_c = len(inner_c | {j for _, j in alignment.pairs})
    return _judge(alignment, expected_e, expected_c, density, config.visible_near, config)


def whole(edge_map: EdgeMap) -> PointMap:
    """Return all points of an edge-map, the terminal first."""
    terminal = np.array([[edge_map.terminal_x, 0.0]])
    return PointMap(np.concatenate((terminal, edge_map.landmarks)), edge_map.covariance, tied=True)


def near(edge_map: EdgeMap, radius_m: float) -> Indices:
    """Return the indices of the landmarks within ``radius_m`` of the origin."""
    return np.flatnonzero(np.hypot(*edge_map.landmarks.T) < radius_m)


def part(edge_map: EdgeMap, indices: Indices) -> PointMap:
    """Return some of an edge-map's landmarks, without the terminal."""
    rows = (2 + 2 * indices[:, None] + np.arange(2)).reshape(-1)
    return PointMap(edge_map.landmarks[indices], edge_map.covariance[np.ix_(rows, rows)], tied=False)


def _density(existing: EdgeMap, candidate: EdgeMap) -> float:
    """Return landmarks per metre of wall, two walls an edge, from the better furnished map."""
    densest = max(m.size / (2.0 * (max(m.terminal_x, m.path_length_m) + _SIDE_ARMS_M)) for m in (existing, candidate))
    return min(max(densest, 0.2), 3.0)


def _judge(
    alignment: Alignment, expected_e: int, expected_c: int, density: float, visible: float, config: AtlasConfig
) -> MapMatch:
    """Weigh pairs and the landmarks left alone; ``expected_*`` count those that ought to be in the other map."""
    pairs = len(alignment.pairs)
    alone = expected_e + expected_c - 2 * pairs
    # Somewhere else a landmark is left alone when none stands by chance within the gate along the wall.
    chance = 2.0 * math.sqrt(config.pair_gate) * alignment.sigma_m * density
    # How much of one map the other shows varies with the floor: no worse is assumed than what is seen here.
    shown = min(max(2.0 * pairs / max(2.0 * pairs + alone, 1.0), _LEAST_SHOWN), visible)
    evidence = alignment.gain + pairs * math.log(shown) + alone * (math.log(1.0 - shown) + min(chance, _CHANCE_MOST))
    fraction = pairs / max(expected_e, expected_c, 1)
    distance = alignment.chi / max(alignment.freedom, 1)
    enough = pairs >= _FEWEST_PAIRS and fraction >= config.least_fraction
    telling = evidence > 0.0 or (fraction >= _CLEAR_FRACTION and pairs >= _MANY_PAIRS)
    agrees = enough and distance <= config.map_distance and telling
    return MapMatch(alignment, evidence, fraction, agrees)
