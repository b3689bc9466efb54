"""The edge-map seen from its other end."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse, reverse_jacobian
from hslam_types.se2 import SE2


def edge_map(seed: int, size: int) -> EdgeMap:
    """Return a map of random landmarks with a full covariance, the terminal's y known."""
    rng = np.random.default_rng(seed)
    root = rng.normal(0.0, 0.02, (2 + 2 * size, 2 + 2 * size))
    root[1] = 0.0
    return EdgeMap(
        traversal=4,
        arrival=5,
        terminal_x=float(rng.uniform(1.0, 60.0)),
        landmarks=rng.uniform(-5.0, 60.0, (size, 2)),
        covariance=root @ root.T,
        sightings=tuple(range(size)),
        departure_heading=0.3,
        arrival_heading=-2.9,
        robot_at_arrival=SE2(*rng.uniform(-3.0, 3.0, 3).tolist()),
        path_length_m=62.0,
    )


@given(seed=st.integers(0, 10_000), size=st.integers(0, 20))
def test_twice_reversed_is_the_map_again(seed: int, size: int) -> None:
    there = edge_map(seed, size)
    again = reverse(reverse(there))
    assert again.landmarks == pytest.approx(there.landmarks, abs=1e-9)
    assert again.covariance == pytest.approx(there.covariance, abs=1e-12)
    assert again.robot_at_arrival == pytest.approx(there.robot_at_arrival, abs=1e-9)
    assert again.departure_heading == pytest.approx(there.departure_heading)
    assert again.arrival_heading == pytest.approx(there.arrival_heading)
    assert (again.traversal, again.arrival, again.sightings) == (4, 5, there.sightings)


def test_reversed_positions_are_those_seen_from_the_terminal() -> None:
    there = edge_map(1, 5)
    back = SE2(there.terminal_x, 0.0, math.pi).inverse()
    assert reverse(there).landmarks == pytest.approx(back.apply_all(there.landmarks))
    assert reverse(there).robot_at_arrival == pytest.approx(back @ there.robot_at_arrival)
    assert reverse(there).terminal_x == there.terminal_x
    assert reverse(there).departure_heading == pytest.approx(there.arrival_heading + math.pi)
    assert reverse(there).arrival_heading == pytest.approx(there.departure_heading - math.pi)


@given(seed=st.integers(0, 10_000), size=st.integers(0, 20))
def test_reversed_covariance_agrees_with_samples_of_the_map(seed: int, size: int) -> None:
    there = edge_map(seed, size)
    rng = np.random.default_rng(seed)
    error = rng.multivariate_normal(np.zeros(2 + 2 * size), there.covariance, method="svd")
    moved = np.array([there.terminal_x + error[0], 0.0]) - (there.landmarks + error[2:].reshape(-1, 2))
    expected = np.concatenate(([error[0], -error[1]], (moved - reverse(there).landmarks).reshape(-1)))
    assert reverse_jacobian(size) @ error == pytest.approx(expected, abs=1e-9)


def test_reversed_covariance_stays_positive_with_a_known_terminal_y() -> None:
    covariance = reverse(edge_map(3, 8)).covariance
    assert np.linalg.eigvalsh(covariance).min() > -1e-12
    assert not covariance[1].any()
