"""The sensor model h(X) of eqs. 3 to 5 and its inverse g: range and bearing of point landmarks.

All functions take many landmarks at once; poses are (x, y, theta), sightings are rows (range m, bearing rad).
"""

import math

import numpy as np

from hslam_types.se2 import Array, wrap_all


def observe(pose: Array, landmarks: Array) -> Array:
    """Return h, n x 2: what a robot at ``pose`` (3) should measure of ``landmarks`` (n x 2)."""
    delta = landmarks - pose[:2]
    expected = np.empty_like(delta)
    expected[:, 0] = np.hypot(delta[:, 0], delta[:, 1])
    expected[:, 1] = wrap_all(np.arctan2(delta[:, 1], delta[:, 0]) - pose[2])
    return expected


def observe_jacobians(pose: Array, landmarks: Array) -> tuple[Array, Array]:
    """Return the derivatives of h by the pose (n x 2 x 3) and each by its landmark (n x 2 x 2)."""
    delta = landmarks - pose[:2]
    distance = np.maximum(np.hypot(delta[:, 0], delta[:, 1]), 1e-6)
    unit = delta / distance[:, None]
    by_landmark = np.empty((len(landmarks), 2, 2))
    by_landmark[:, 0] = unit
    by_landmark[:, 1, 0] = -unit[:, 1] / distance
    by_landmark[:, 1, 1] = unit[:, 0] / distance
    by_pose = np.empty((len(landmarks), 2, 3))
    by_pose[:, :, :2] = -by_landmark
    by_pose[:, 0, 2] = 0.0
    by_pose[:, 1, 2] = -1.0
    return by_pose, by_landmark


def locate(pose: Array, sightings: Array) -> Array:
    """Return g, n x 2: where a robot at ``pose`` (3) puts what it sees."""
    direction = pose[2] + sightings[:, 1]
    points: Array = pose[:2] + sightings[:, :1] * np.column_stack((np.cos(direction), np.sin(direction)))
    return points


def locate_jacobians(pose: Array, sightings: Array) -> tuple[Array, Array]:
    """Return the derivatives of g by the pose (n x 2 x 3) and each by its sighting (n x 2 x 2)."""
    direction = pose[2] + sightings[:, 1]
    c, s, distance = np.cos(direction), np.sin(direction), sightings[:, 0]
    by_pose = np.zeros((len(sightings), 2, 3))
    by_pose[:, 0, 0] = by_pose[:, 1, 1] = 1.0
    by_pose[:, 0, 2], by_pose[:, 1, 2] = -distance * s, distance * c
    by_sighting = np.empty((len(sightings), 2, 2))
    by_sighting[:, 0, 0], by_sighting[:, 0, 1] = c, -distance * s
    by_sighting[:, 1, 0], by_sighting[:, 1, 1] = s, distance * c
    return by_pose, by_sighting


def relative_point(pose: Array, x: float, y: float) -> tuple[Array, Array]:
    """Return a point (2) given in base_link, brought into the pose's frame, and its derivative (2 x 3) by the pose."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    offset = np.array([c * x - s * y, s * x + c * y])
    return pose[:2] + offset, np.array([[1.0, 0.0, -offset[1]], [0.0, 1.0, offset[0]]])
