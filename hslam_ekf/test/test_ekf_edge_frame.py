"""The frame through the terminal: rigid for the mean, exact in its first-order covariance."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_ekf.edge_frame import turn_to_terminal
from hslam_types.se2 import Array


def state(seed: int, landmarks: int, spread: float = 0.05) -> tuple[Array, Array]:
    """Return a random X = [robot | landmarks, terminal] and a full covariance."""
    rng = np.random.default_rng(seed)
    size = 4 + 2 * landmarks + 2
    root = rng.normal(0.0, spread / math.sqrt(size), (size, size))
    mean = rng.uniform(-20.0, 20.0, size)
    mean[2] = rng.uniform(-math.pi, math.pi)
    return mean, root @ root.T


@given(seed=st.integers(0, 10_000), landmarks=st.integers(0, 12))
def test_turning_keeps_distances_and_puts_the_terminal_on_the_axis(seed: int, landmarks: int) -> None:
    mean, covariance = state(seed, landmarks)
    turned, spread, phi = turn_to_terminal(mean, covariance)
    before = np.concatenate((mean[:2], mean[4:])).reshape(-1, 2)
    after = np.concatenate((turned[:2], turned[4:])).reshape(-1, 2)
    gaps = np.linalg.norm(before[:, None] - before[None], axis=2)
    assert np.linalg.norm(after[:, None] - after[None], axis=2) == pytest.approx(gaps, abs=1e-9)
    assert turned[-2] == pytest.approx(math.hypot(*mean[-2:]))
    assert turned[-1] == 0.0
    assert phi == math.atan2(mean[-1], mean[-2])
    assert not spread[-1].any()
    assert np.array_equal(spread, spread.T)
    assert np.linalg.eigvalsh(spread).min() > -1e-10


def test_covariance_agrees_with_samples() -> None:
    mean, covariance = state(seed=7, landmarks=3, spread=0.02)
    turned, spread, _ = turn_to_terminal(mean, covariance)
    rng = np.random.default_rng(0)
    samples = rng.multivariate_normal(mean, covariance, 4000)
    moved = np.array([turn_to_terminal(sample, covariance)[0] for sample in samples]) - turned
    moved[:, 2] = np.arctan2(np.sin(moved[:, 2]), np.cos(moved[:, 2]))
    scale = np.sqrt(np.outer(np.diag(spread), np.diag(spread))) + 1e-12
    assert np.abs((moved.T @ moved / len(moved) - spread) / scale).max() < 0.1


def test_a_terminal_at_the_origin_gives_no_direction() -> None:
    mean, covariance = state(seed=8, landmarks=2)
    mean[-2:] = (0.1, 0.2)
    turned, spread, phi = turn_to_terminal(mean, covariance)
    assert phi == 0.0
    assert np.array_equal(turned[:-1], mean[:-1])
    assert np.array_equal(spread[:-1, :-1], covariance[:-1, :-1])
