"""The live map's picture: what it says of each landmark is what the filter says."""

import math

import numpy as np

from hslam_ekf.config import EkfConfig
from hslam_ekf.ekf_messages import map_to_msg
from hslam_ekf.landmark_filter import LandmarkFilter
from hslam_ekf.motion_model import ROBOT
from hslam_types.se2 import SE2

SCALE = 3.0


def test_every_ellipse_is_as_many_sigmas_wide_as_it_says() -> None:
    ekf = LandmarkFilter(SE2(1.0, 2.0, 0.5), 0.0, math.radians(1.0) ** 2, EkfConfig())
    ekf.predict(SE2(0.5, 0.0, 0.3))
    ekf.augment(np.array([[2.0, 0.1], [4.0, -1.0], [1.0, 2.0]]), np.array([[0.01, 0.001]] * 3))
    landmarks, ellipses = map_to_msg(0, 0, ekf, SCALE).markers
    assert [(point.x, point.y) for point in landmarks.points] == [tuple(row) for row in ekf.landmarks.tolist()]
    rings = np.array([(point.x, point.y) for point in ellipses.points]).reshape(3, -1, 2)
    for i, offsets in enumerate(rings - ekf.landmarks[:, None]):
        own = slice(ROBOT + 2 * i, ROBOT + 2 * i + 2)
        chi = np.einsum("ij,jk,ik->i", offsets, np.linalg.inv(ekf.covariance[own, own]), offsets)
        np.testing.assert_allclose(np.sqrt(chi), SCALE, rtol=1e-6)


def test_a_map_without_landmarks_is_an_empty_picture() -> None:
    landmarks, ellipses = map_to_msg(0, 0, LandmarkFilter(SE2(), 0.0, 0.0, EkfConfig()), SCALE).markers
    assert not landmarks.points
    assert not ellipses.points
