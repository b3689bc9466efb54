"""Aligning two maps by the filter on the frame offset, and what the match is worth."""

import math

import numpy as np
import pytest
from corridor_floor import furnish, wean_hall
from edge_walker import EdgeWalker, WalkNoise

from hslam_atlas.alignment import PointMap, _OffsetFilter, align
from hslam_atlas.config import AtlasConfig
from hslam_atlas.map_match import match_constellations, match_edges
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import GoalKind, GvgGoal
from hslam_types.se2 import SE2, rotation, wrap

WEST, EAST = math.pi, 0.0
FLOOR = furnish(wean_hall(), np.random.default_rng(5))


def drives(count: int, seed: int, *, bearing: float = WEST) -> list[EdgeMap]:
    """Return maps of one edge of a floor, driven from the same end again and again: west it is 36 m long, east 16."""
    return [edge_map for edge_map, _, _ in drives_with_truth(count, seed, bearing=bearing)]


def drives_with_truth(count: int, seed: int, *, bearing: float = WEST) -> list[tuple[EdgeMap, SE2, float]]:
    """Return `drives`, each with the true pose of its edge frame on `FLOOR` and the true distance of its ends (m)."""
    found: list[tuple[EdgeMap, SE2, float]] = []
    for k in range(count):
        noise = WalkNoise(degree_misread=0.0, node_missed=0.0)
        walker = EdgeWalker(FLOOR, 2, np.random.default_rng(seed + k), noise)
        walker.follow(GvgGoal(GoalKind.ACCESS))
        steps = walker.follow(GvgGoal(GoalKind.TRACE, walker.branch_towards(bearing)))
        found += [(edge_map, *walker.true_edge()) for step in steps for edge_map in step.edge_maps]
    return found


def cloud(rng: np.random.Generator, n: int, std: float) -> tuple[np.ndarray, PointMap]:
    """Return true points and a map of them."""
    places = np.array([(x, y) for x in (-4.0, -2.0, 0.0, 2.0, 4.0) for y in (-3.0, 0.0, 3.0)])
    true = rng.permutation(places)[:n] + rng.uniform(-0.4, 0.4, (n, 2))
    return true, PointMap(true + rng.normal(0.0, std, true.shape), np.eye(2 * n) * std**2, tied=False)


@pytest.mark.parametrize("theta", [0.0, 1.0, math.pi - 1e-3, -math.pi + 1e-3])
def test_innovation_jacobian_is_the_numeric_one(theta: float) -> None:
    rng = np.random.default_rng(2)
    _, existing = cloud(rng, 3, 0.1)
    _, candidate = cloud(rng, 3, 0.1)
    offset_filter = _OffsetFilter(existing, candidate, SE2(0.3, -0.2, theta), np.eye(3))
    pair = offset_filter.innovation(1, 2, 0.0)
    start = offset_filter.mean.copy()
    step = 1e-6
    for n, column in enumerate(pair.columns):
        offset_filter.mean = start.copy()
        offset_filter.mean[column] += step
        numeric = (offset_filter.innovation(1, 2, 0.0).innovation - pair.innovation) / step
        np.testing.assert_allclose(pair.jacobian[:, n], numeric, atol=1e-5)


def test_offset_is_found_and_its_covariance_honest() -> None:
    truth = SE2(0.1, -0.05, 0.08)
    squared = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        true, existing = cloud(rng, 14, 0.04)
        seen = (true - [truth.x, truth.y]) @ rotation(truth.theta)
        candidate = PointMap(seen + rng.normal(0.0, 0.04, seen.shape), np.eye(28) * 0.04**2, tied=False)
        found = align(
            existing, candidate, SE2(), np.diag([0.1**2, 0.1**2, 0.1**2]),
            density=1.0, pair_noise_m=0.001, terminal_noise_m=0.0, gate=14.0,
        )  # fmt: skip
        assert len(found.pairs) >= 12
        assert all(i == j for i, j in found.pairs)
        error = np.array([found.offset.x - 0.1, found.offset.y + 0.05, wrap(found.offset.theta - 0.08)])
        squared.append(error @ np.linalg.solve(found.offset_covariance, error))
    # Mean of 60 chi-square values of 3 degrees of freedom: 3 +- 4 sigma of sqrt(6 / 60).
    assert 3.0 - 4.0 * math.sqrt(0.1) < np.mean(squared) < 3.0 + 4.0 * math.sqrt(0.1)


def test_posterior_is_symmetric_and_smaller_than_the_prior() -> None:
    first, second = drives(2, 20)
    match = match_edges(first, second, SE2(), np.diag([0.01, 0.01, 1e-4]), 0.08, AtlasConfig())
    posterior = match.alignment.covariance()
    np.testing.assert_allclose(posterior, posterior.T, atol=1e-12)
    assert np.linalg.eigvalsh(posterior)[0] > -1e-9
    assert np.all(np.diag(posterior) <= np.diag(match.alignment.prior_covariance) + 1e-12)


def test_two_drives_along_one_edge_match_from_either_end() -> None:
    config = AtlasConfig()
    prior = np.diag([0.0072, 0.0072, math.radians(0.5) ** 2])
    for seed in range(5):
        first, second = drives(2, 40 + 10 * seed)
        for a, b in ((first, second), (reverse(first), reverse(second))):
            match = match_edges(a, b, SE2(), prior, 0.085, config)
            assert match.agrees
            assert match.evidence > 20.0
            assert match.fraction > 0.8


def test_different_edges_do_not_match() -> None:
    config = AtlasConfig()
    prior = np.diag([0.0072, 0.0072, math.radians(5.0) ** 2])
    (one,), (other,) = drives(1, 3, bearing=WEST), drives(1, 3, bearing=EAST)
    for a, b in ((one, other), (reverse(one), other), (one, reverse(other))):
        match = match_constellations(a, b, SE2(), prior, config)
        assert not match.agrees
        assert match.evidence < -3.0


def test_few_pairs_do_not_make_a_match() -> None:
    """A poor fit leaves few pairs with a deceptively small map distance (section III-B)."""
    config = AtlasConfig()
    (edge_map,) = drives(1, 9)
    keep = 4
    rows = np.arange(2 + 2 * keep)
    few = EdgeMap(
        1, 2, edge_map.terminal_x, edge_map.landmarks[:keep], edge_map.covariance[np.ix_(rows, rows)], (9,) * keep,
        0.0, math.pi, SE2(), edge_map.path_length_m,
    )  # fmt: skip
    match = match_edges(edge_map, few, SE2(), np.diag([0.01, 0.01, 1e-4]), 0.1, config)
    assert match.alignment.chi / match.alignment.freedom < config.map_distance
    assert not match.agrees
