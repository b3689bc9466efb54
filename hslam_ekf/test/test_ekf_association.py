"""Two gates and the joint assignment between them."""

import numpy as np

from hslam_ekf.association import Association, associate
from hslam_types.se2 import Array

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
