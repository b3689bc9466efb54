"""Two gates and the joint assignment between them."""

import math
from itertools import permutations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_ekf.association import Association, associate
from hslam_types.se2 import Array, wrap

VARIANCES = (0.05**2, 0.02**2)


def verdict(sightings: list[tuple[float, float]], expected: list[tuple[float, float]]) -> Association:
    """Associate with landmarks as well known as the sensor is exact."""
    noise: Array = np.tile(VARIANCES, (len(sightings), 1))
    spread = np.tile(np.diag(VARIANCES), (len(expected), 1, 1))
    return associate(
        np.array(sightings).reshape(-1, 2), noise, np.array(expected).reshape(-1, 2), spread,
        accept_gate=11.8, new_gate=30.0,
    )  # fmt: skip


def test_each_sighting_finds_its_landmark_across_the_cut() -> None:
    found = verdict([(3.0, 3.13), (5.0, 0.0)], [(5.02, 0.01), (3.01, -3.14)])
    assert found.sightings.tolist() == [0, 1]
    assert found.landmarks.tolist() == [1, 0]
    assert not len(found.fresh)


def test_between_the_gates_a_sighting_is_dropped() -> None:
    # chi = (0.3 / 0.0707)^2 = 18
    found = verdict([(3.3, 0.0)], [(3.0, 0.0)])
    assert not len(found.sightings)
    assert not len(found.fresh)


def test_beyond_the_upper_gate_it_is_new() -> None:
    assert verdict([(3.5, 0.0)], [(3.0, 0.0)]).fresh.tolist() == [0]


def test_two_that_compete_are_assigned_together() -> None:
    # Both are nearest to the landmark at 3.1 m; only one may have it, and together they fit best in order.
    found = verdict([(3.05, 0.0), (3.2, 0.0)], [(3.1, 0.0), (2.95, 0.0)])
    assert dict(zip(found.sightings.tolist(), found.landmarks.tolist(), strict=True)) == {0: 1, 1: 0}


def test_the_loser_of_one_landmark_is_no_new_one() -> None:
    found = verdict([(3.0, 0.0), (3.1, 0.0)], [(3.0, 0.0)])
    assert found.sightings.tolist() == [0]
    assert not len(found.fresh)


def test_nothing_seen_and_nothing_known() -> None:
    assert not len(verdict([], [(3.0, 0.0)]).fresh)
    assert verdict([(3.0, 0.0)], []).fresh.tolist() == [0]


def test_a_vague_landmark_does_not_win_by_being_vague() -> None:
    """Less likely, though its chi is the smaller: 0.9 against 2.0."""
    noise = np.array([VARIANCES])
    spread = np.array([np.diag(VARIANCES), np.diag((0.2**2, 0.02**2))])
    expected = np.array([[3.1, 0.0], [3.2, 0.0]])
    found = associate(np.array([[3.0, 0.0]]), noise, expected, spread, accept_gate=11.8, new_gate=30.0)
    assert found.landmarks.tolist() == [0]


def best_by_trying_all(cost: Array, gated: npt.NDArray[np.bool_]) -> tuple[int, float]:
    """Return the most pairs that pass the gate, each sighting and landmark in one, and the least sum of their costs."""
    wide = max(cost.shape)
    padded, allowed = np.zeros((wide, wide)), np.zeros((wide, wide), dtype=bool)
    padded[: cost.shape[0], : cost.shape[1]], allowed[: cost.shape[0], : cost.shape[1]] = cost, gated
    found = []
    for columns in permutations(range(wide)):
        pairs = [(row, column) for row, column in enumerate(columns) if allowed[row, column]]
        found.append((-len(pairs), float(sum(padded[pair] for pair in pairs))))
    count, least = min(found)
    return -count, least


@given(seed=st.integers(0, 100_000), sightings=st.integers(0, 4), landmarks=st.integers(0, 4))
def test_no_other_assignment_is_likelier(seed: int, sightings: int, landmarks: int) -> None:
    """Against every assignment there is, with S inverted as a matrix; landmarks crowd about the cut at pi."""
    rng = np.random.default_rng(seed)
    expected = np.column_stack((rng.uniform(3.0, 3.6, landmarks), math.pi + rng.uniform(-0.15, 0.15, landmarks)))
    seen = np.column_stack((rng.uniform(3.0, 3.6, sightings), math.pi + rng.uniform(-0.15, 0.15, sightings)))
    expected[:, 1], seen[:, 1] = [[wrap(b) for b in rows[:, 1].tolist()] for rows in (expected, seen)]
    roots = rng.normal(0.0, 1.0, (landmarks, 2, 2)) * (0.08 * rng.random((landmarks, 1, 1)))
    spread = roots @ roots.transpose(0, 2, 1)
    noise = rng.uniform(0.01, 0.06, (sightings, 2)) ** 2
    chi, likelihood = np.zeros((sightings, landmarks)), np.zeros((sightings, landmarks))
    for i in range(sightings):
        for k in range(landmarks):
            s = spread[k] + np.diag(noise[i])
            off = np.array([seen[i, 0] - expected[k, 0], wrap(float(seen[i, 1] - expected[k, 1]))])
            chi[i, k] = off @ np.linalg.solve(s, off)
            likelihood[i, k] = chi[i, k] + math.log(np.linalg.det(s))
    found = associate(seen, noise, expected, spread, accept_gate=8.0, new_gate=15.0)
    pairs = list(zip(found.sightings.tolist(), found.landmarks.tolist(), strict=True))
    assert len(set(found.sightings.tolist())) == len(set(found.landmarks.tolist())) == len(pairs)
    assert all(chi[pair] < 8.0 for pair in pairs)
    count, least = best_by_trying_all(likelihood, chi < 8.0)
    assert len(pairs) == count
    assert sum(likelihood[pair] for pair in pairs) == pytest.approx(least)
    assert found.fresh.tolist() == [i for i in range(sightings) if all(chi[i] > 15.0)]
