"""The filter against its textbook form, and what must hold whatever it is fed."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hslam_ekf.association import Indices
from hslam_ekf.config import EkfConfig
from hslam_ekf.landmark_filter import LandmarkFilter
from hslam_ekf.motion_model import ROBOT
from hslam_ekf.range_bearing import observe, observe_jacobians
from hslam_types.se2 import SE2, Array

NOISE = np.array([0.05**2, math.radians(1.0) ** 2])


def driven(seed: int, steps: int, landmarks: int) -> tuple[LandmarkFilter, np.random.Generator]:
    """Return a filter that has driven and corrected for some steps among landmarks all round it."""
    rng = np.random.default_rng(seed)
    ekf = LandmarkFilter(SE2(0.1, -0.1, 3.1), 0.0, 0.02**2, EkfConfig())
    ekf.augment(rng.uniform((0.5, -math.pi), (6.0, math.pi), (landmarks, 2)), np.tile(NOISE, (landmarks, 1)))
    for _ in range(steps):
        ekf.predict(SE2(*rng.normal((0.05, 0.0, 0.05), (0.02, 0.005, 0.1)).tolist()))
        seen = np.flatnonzero(rng.random(landmarks) < 0.6)
        expected = ekf.expect(np.arange(landmarks))
        readings = expected.sightings[seen] + rng.normal(0.0, NOISE**0.5, (len(seen), 2))
        ekf.correct(expected, seen, readings, np.tile(NOISE, (len(seen), 1)))
    return ekf, rng


def dense_h(ekf: LandmarkFilter, landmarks: Indices) -> Array:
    """Return grad h of the given landmarks over the whole state."""
    by_pose, by_landmark = observe_jacobians(ekf.mean[:3], ekf.landmarks[landmarks])
    h = np.zeros((2 * len(landmarks), len(ekf.mean)))
    for row, landmark in enumerate(landmarks):
        h[2 * row : 2 * row + 2, :3] = by_pose[row]
        h[2 * row : 2 * row + 2, ROBOT + 2 * landmark : ROBOT + 2 * landmark + 2] = by_landmark[row]
    return h


def test_correction_equals_the_joseph_form() -> None:
    ekf, rng = driven(seed=1, steps=20, landmarks=6)
    chosen = np.array([4, 0, 3])
    expected = ekf.expect(np.arange(6))
    readings = expected.sightings[chosen] + rng.normal(0.0, NOISE**0.5, (3, 2))
    readings[:, 1] += 2.0 * math.pi  # another turn must change nothing
    h, p, r = dense_h(ekf, chosen), ekf.covariance.copy(), np.diag(np.tile(NOISE, 3))
    gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
    innovation = (readings - np.array([0.0, 2.0 * math.pi]) - observe(ekf.mean[:3], ekf.landmarks[chosen])).reshape(-1)
    mean = ekf.mean + gain @ innovation
    rest = np.eye(len(p)) - gain @ h
    ekf.correct(expected, chosen, readings, np.tile(NOISE, (3, 1)))
    assert ekf.mean == pytest.approx(mean, abs=1e-9)
    assert ekf.covariance == pytest.approx(rest @ p @ rest.T + gain @ r @ gain.T, abs=1e-12)
    assert ekf.nis[1] == 6


def test_expected_spread_is_the_diagonal_of_the_joint_one() -> None:
    ekf, _ = driven(seed=2, steps=5, landmarks=4)
    h = dense_h(ekf, np.arange(4))
    joint = h @ ekf.covariance @ h.T
    for i, spread in enumerate(ekf.expect(np.arange(4)).spread):
        assert spread == pytest.approx(joint[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], abs=1e-12)


@settings(deadline=None, max_examples=25)
@given(seed=st.integers(0, 10_000), steps=st.integers(1, 60), landmarks=st.integers(1, 50))
def test_covariance_stays_symmetric_and_positive(seed: int, steps: int, landmarks: int) -> None:
    ekf, _ = driven(seed, steps, landmarks)
    assert np.array_equal(ekf.covariance, ekf.covariance.T)
    assert np.linalg.eigvalsh(ekf.covariance).min() > -1e-12
    assert -math.pi <= ekf.mean[2] < math.pi


def test_many_corrections_do_not_undermine_the_covariance() -> None:
    ekf, _ = driven(seed=3, steps=3000, landmarks=12)
    assert np.array_equal(ekf.covariance, ekf.covariance.T)
    assert np.linalg.eigvalsh(ekf.covariance).min() > 0.0


def test_augmenting_leaves_the_rest_alone() -> None:
    ekf, rng = driven(seed=4, steps=10, landmarks=8)
    mean, covariance = ekf.mean.copy(), ekf.covariance.copy()
    ekf.augment(rng.uniform((1.0, -3.0), (6.0, 3.0), (60, 2)), np.tile(NOISE, (60, 1)))
    assert len(ekf.landmarks) == 68
    assert np.array_equal(ekf.mean[: len(mean)], mean)
    assert np.array_equal(ekf.covariance[: len(mean), : len(mean)], covariance)
    assert np.linalg.eigvalsh(ekf.covariance).min() > 0.0


def test_keeping_some_landmarks_marginalises_the_others() -> None:
    ekf, _ = driven(seed=5, steps=10, landmarks=5)
    rows = [0, 1, 2, 3, 4 + 2, 4 + 3, 4 + 8, 4 + 9]
    mean, covariance = ekf.mean[rows].copy(), ekf.covariance[np.ix_(rows, rows)].copy()
    ekf.keep(np.array([1, 4]))
    assert np.array_equal(ekf.mean, mean)
    assert np.array_equal(ekf.covariance, covariance)


def test_prediction_without_slip_turns_uncertainty_only() -> None:
    still = EkfConfig(slip_per_metre=0.0, turn_slip_per_metre=0.0, turn_slip_per_radian=0.0, turn_bias_per_metre=0.0)
    ekf = LandmarkFilter(SE2(1.0, 2.0, 0.5), 0.0, 0.0, still)
    ekf.predict(SE2(0.3, 0.1, 0.2))
    assert ekf.pose()[0] == pytest.approx(SE2(1.0, 2.0, 0.5) @ SE2(0.3, 0.1, 0.2))
    assert not ekf.covariance.any()
