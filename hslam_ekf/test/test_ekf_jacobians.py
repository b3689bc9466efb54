"""Every analytic derivative against central differences, also across the cut at +-pi."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_ekf.edge_frame import turn, turn_jacobian
from hslam_ekf.motion_model import move, move_jacobian, stated_noise
from hslam_ekf.range_bearing import (
    locate,
    locate_jacobians,
    observe,
    observe_jacobians,
    relative_point,
)
from hslam_types.se2 import SE2, Array, wrap_all

ANGLES = st.one_of(st.floats(-math.pi, math.pi), st.sampled_from([-math.pi, math.pi - 1e-9, -math.pi + 1e-9, 0.0]))
METRES = st.floats(-30.0, 30.0)
POSES = st.tuples(METRES, METRES, ANGLES).map(np.array)


def numeric(function: Callable[[Array], Array], at: Array, angles: list[int]) -> Array:
    """Return the derivative of ``function`` by central differences; rows in ``angles`` are differences of angles."""
    columns = []
    for i in range(len(at)):
        step = np.zeros(len(at))
        step[i] = 1e-6
        difference = function(at + step) - function(at - step)
        difference[angles] = wrap_all(difference[angles])
        columns.append(difference / 2e-6)
    return np.array(columns).T


@given(
    pose=POSES,
    bias=st.floats(-0.05, 0.05),
    step=st.tuples(st.floats(-0.2, 0.2), st.floats(-0.1, 0.1), ANGLES),
    biased=st.booleans(),
)
def test_move(pose: Array, bias: float, step: tuple[float, float, float], *, biased: bool) -> None:
    robot, odometry = np.append(pose, bias), SE2(*step)
    expected = numeric(lambda x: move(x, odometry, biased=biased), robot, [2])
    assert move_jacobian(robot, odometry, biased=biased) == pytest.approx(expected, abs=1e-6)


@given(pose=POSES, step=st.builds(SE2, st.floats(-0.2, 0.2), st.floats(-0.1, 0.1), ANGLES))
def test_a_stated_noise_is_turned_as_the_step_is(pose: Array, step: SE2) -> None:
    by_step = numeric(lambda s: move(np.append(pose, 0.0), SE2(*s.tolist()))[:3], np.array(step), [2])
    noise = np.array([[3.0, 1.0, 0.5], [1.0, 2.0, -0.3], [0.5, -0.3, 1.0]])
    spread = stated_noise(np.append(pose, 0.0), noise)
    assert spread[:3, :3] == pytest.approx(by_step @ noise @ by_step.T, abs=1e-6)
    assert not spread[3].any()
    assert not spread[:, 3].any()


@given(pose=POSES, distance=st.floats(0.2, 20.0), bearing=ANGLES)
def test_observe(pose: Array, distance: float, bearing: float) -> None:
    landmark = locate(pose, np.array([[distance, bearing]]))
    by_pose, by_landmark = observe_jacobians(pose, landmark)
    assert by_pose[0] == pytest.approx(numeric(lambda x: observe(x, landmark)[0], pose, [1]), abs=1e-5)
    expected = numeric(lambda point: observe(pose, point[None])[0], landmark[0], [1])
    assert by_landmark[0] == pytest.approx(expected, abs=1e-5)


@given(pose=POSES, distance=st.floats(0.2, 20.0), bearing=ANGLES)
def test_locate(pose: Array, distance: float, bearing: float) -> None:
    sighting = np.array([[distance, bearing]])
    by_pose, by_sighting = locate_jacobians(pose, sighting)
    assert by_pose[0] == pytest.approx(numeric(lambda x: locate(x, sighting)[0], pose, []), abs=1e-5)
    assert by_sighting[0] == pytest.approx(numeric(lambda z: locate(pose, z[None])[0], sighting[0], []), abs=1e-5)


@given(pose=POSES, distance=st.floats(0.2, 20.0), bearing=ANGLES)
def test_locate_inverts_observe(pose: Array, distance: float, bearing: float) -> None:
    again = observe(pose, locate(pose, np.array([[distance, bearing]])))[0]
    assert again[0] == pytest.approx(distance)
    assert abs(wrap_all(again[1:] - bearing)[0]) < 1e-9


@given(pose=POSES, x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0))
def test_relative_point(pose: Array, x: float, y: float) -> None:
    point, by_pose = relative_point(pose, x, y)
    assert point == pytest.approx(np.array(SE2(*pose.tolist()).apply(x, y)))
    assert by_pose == pytest.approx(numeric(lambda at: relative_point(at, x, y)[0], pose, []), abs=1e-5)


@given(pose=POSES, landmark=st.tuples(METRES, METRES), length=st.floats(1.0, 80.0), direction=ANGLES)
def test_turn_through_the_terminal(pose: Array, landmark: tuple[float, float], length: float, direction: float) -> None:
    terminal = (length * math.cos(direction), length * math.sin(direction))
    mean = np.array([*pose, 0.01, *landmark, *terminal])

    def through_terminal(x: Array) -> Array:
        return turn(x, math.atan2(x[-1], x[-2]))

    jacobian = turn_jacobian(mean, math.atan2(mean[-1], mean[-2]), depends_on_terminal=True)
    assert jacobian == pytest.approx(numeric(through_terminal, mean, [2]), abs=1e-5)
