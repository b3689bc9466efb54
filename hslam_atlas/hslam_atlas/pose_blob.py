"""A pose with its covariance as bytes: twelve little-endian doubles, exact."""

import numpy as np

from hslam_atlas.errors import ContentError
from hslam_atlas.schema import LARGEST
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.se2 import SE2

_SIZE = 12 * 8
"""Bytes: x, y, theta and a covariance of 3 x 3, each in 64 bits."""
_ROUNDING = 1e-6
"""How far a covariance may be from symmetric and positive by rounding, as a share of its largest entry."""


def encode(pose: UncertainPose) -> bytes:
    """Return the bytes of a pose: x, y (m), theta (rad), covariance row by row."""
    return np.concatenate((np.array(pose.pose), pose.covariance.ravel())).astype("<f8").tobytes()


def decode(blob: bytes) -> UncertainPose:
    """Return the pose of ``blob``; raises ContentError if it is not one."""
    if len(blob) != _SIZE:
        raise ContentError(f"is no pose of {_SIZE} bytes")
    values = np.frombuffer(blob, "<f8").astype(np.float64)
    covariance = values[3:].reshape(3, 3)
    if not (np.abs(values) <= LARGEST).all():
        raise ContentError("is no pose: it holds what is no number")
    rounding = _ROUNDING * float(np.abs(covariance).max())
    if np.abs(covariance - covariance.T).max() > rounding or np.linalg.eigvalsh(covariance).min() < -rounding:
        raise ContentError("is no pose: its covariance is none")
    x, y, theta = values[:3].tolist()
    return UncertainPose(SE2(x, y, theta), covariance)
