"""Planar motions: group laws, and Jacobians against numeric ones."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.se2 import SE2, Array, compose_jacobians, inverse_jacobian, rotation, wrap, wrap_all

metres = st.floats(-100.0, 100.0)
angles = st.floats(-10.0, 10.0) | st.sampled_from([math.pi, -math.pi, math.nextafter(math.pi, 0.0)])
poses = st.builds(SE2, metres, metres, angles.map(wrap))


def apart(a: SE2, b: SE2) -> float:
    """Return the largest difference of two poses, the angle's taken round the circle."""
    return max(abs(a.x - b.x), abs(a.y - b.y), abs(wrap(a.theta - b.theta)))


def numeric(function: Callable[[SE2], SE2], at: SE2) -> Array:
    """Return the 3 x 3 central-difference Jacobian of a pose by a pose."""
    step = 1e-6
    columns = []
    for i in range(3):
        low, high = (function(SE2(*(v + sign * step * (k == i) for k, v in enumerate(at)))) for sign in (-1, 1))
        columns.append([(high.x - low.x), (high.y - low.y), wrap(high.theta - low.theta)])
    return np.array(columns).T / (2.0 * step)


@given(angles)
def test_wrap_stays_in_range_and_keeps_the_direction(angle: float) -> None:
    wrapped = wrap(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)
    assert wrap_all(np.array([angle]))[0] == wrapped


@given(poses, poses, poses)
def test_composition_is_associative(a: SE2, b: SE2, c: SE2) -> None:
    assert apart((a @ b) @ c, a @ (b @ c)) < 1e-9


@given(poses, poses)
def test_a_pose_and_its_inverse_cancel(a: SE2, b: SE2) -> None:
    assert apart(a @ a.inverse(), SE2()) < 1e-9
    assert apart(a @ a.to(b), b) < 1e-9


@given(poses, metres, metres)
def test_points_map_alike_one_by_one_and_together(pose: SE2, x: float, y: float) -> None:
    assert np.allclose(pose.apply_all(np.array([[x, y]]))[0], pose.apply(x, y), atol=1e-9)
    assert np.allclose(pose.inverse().apply(*pose.apply(x, y)), (x, y), atol=1e-9)


@given(poses, poses)
def test_compose_jacobians_against_numeric(b_in_c: SE2, a_in_b: SE2) -> None:
    left, right = compose_jacobians(b_in_c, a_in_b)
    assert np.allclose(left, numeric(lambda pose: pose @ a_in_b, b_in_c), atol=1e-6)
    assert np.allclose(right, numeric(lambda pose: b_in_c @ pose, a_in_b), atol=1e-6)


@given(poses)
def test_inverse_jacobian_against_numeric(pose: SE2) -> None:
    assert np.allclose(inverse_jacobian(pose), numeric(SE2.inverse, pose), atol=1e-6)


@pytest.mark.parametrize("theta", [0.0, 1.0, math.pi])
def test_a_rotation_keeps_lengths_and_turns_counter_clockwise(theta: float) -> None:
    assert np.allclose(rotation(theta) @ rotation(theta).T, np.eye(2))
    assert np.allclose(rotation(theta) @ [1.0, 0.0], [math.cos(theta), math.sin(theta)])
