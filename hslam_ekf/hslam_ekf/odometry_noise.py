"""How uncertain a step of odometry is: by the covariances that come with it, where they can be believed.

`nav_msgs/Odometry` offers two. The twist's says how far off the velocity of each sample is, independently of the
others, so that a step of length dt adds C dt^2. The pose's, where a driver integrates it, grows by what each step
adds. Many drivers fill in neither, or numbers that stand for nothing (-1, 1e6, the same 0.01 for ever); then the
configuration's constants hold, and the reason is told.
"""

import math
from enum import Enum

import numpy as np

from hslam_types.se2 import SE2, Array, rotation
from hslam_types.sensing import OdometrySample, PlanarCovariance

_NS_PER_S = 1e9
_LEAST_STD, _MOST_STD = 1e-5, 1.0
"""Deviations (m/s, rad/s; of a step's growth: m, rad) beyond which a number was made up: no wheels are so exact, and
1e6 says that nothing is known."""
_ROUNDING = 1e-9
"""How far, as a share of its largest entry, a covariance may be from positive by the rounding of sums."""


class NoiseSource(Enum):
    """What steps are weighed by."""

    NOT_YET = "nothing yet"
    TWIST = "its twist covariance"
    POSE = "the growth of its pose covariance"
    CONSTANTS = "the configured constants"


class OdometryNoise:
    """Finds the covariance of each step, and says where it came from."""

    def __init__(self) -> None:
        """Begin without a step."""
        self.source = NoiseSource.NOT_YET
        self.reason = ""
        """Why the constants are used, empty where they are not."""

    def of_step(self, before: OdometrySample, after: OdometrySample) -> Array | None:
        """Return the covariance (3 x 3, in base_link at ``before``) of the step; None: the constants are to be used."""
        step = before.base_in_odom.to(after.base_in_odom)
        by_twist, twist_fault = _by_twist(after, step, (after.stamp_ns - before.stamp_ns) / _NS_PER_S)
        if by_twist is not None:
            self.source, self.reason = NoiseSource.TWIST, ""
            return by_twist
        by_pose, pose_fault = _by_pose(before, after)
        if by_pose is not None:
            self.source, self.reason = NoiseSource.POSE, ""
            return by_pose
        self.source = NoiseSource.CONSTANTS
        faults = [fault for fault in (twist_fault, pose_fault) if fault]
        self.reason = "; ".join(faults) or "it gives no covariances"
        return None


def _by_twist(after: OdometrySample, step: SE2, seconds: float) -> tuple[Array | None, str]:
    """Return a step's covariance by that of the velocity, or what is wrong with that."""
    if after.twist_covariance is None:
        return None, ""
    fault = _fault(after.twist_covariance)
    if fault:
        return None, f"its twist covariance {fault}"
    # The heading is off half of the turn's error on the way, which moves the end of the step across it.
    by_twist = seconds * np.array([[1.0, 0.0, -0.5 * step.y], [0.0, 1.0, 0.5 * step.x], [0.0, 0.0, 1.0]])
    return by_twist @ after.twist_covariance.matrix @ by_twist.T, ""


def _by_pose(before: OdometrySample, after: OdometrySample) -> tuple[Array | None, str]:
    """Return a step's covariance by how the pose's has grown, or what is wrong with that.

    A driver that keeps no correlation of place and heading has not carried the heading's error into the place either:
    its variances are sums, one a step.
    """
    if before.pose_covariance is None or after.pose_covariance is None:
        return None, ""
    old, new = before.pose_covariance.matrix, after.pose_covariance.matrix
    if not np.isfinite(old).all() or not np.isfinite(new).all():
        return None, "its pose covariance holds what is no number"
    dx, dy = after.base_in_odom.x - before.base_in_odom.x, after.base_in_odom.y - before.base_in_odom.y
    carried = np.eye(3)
    if new[:2, 2].any():
        carried[:2, 2] = -dy, dx
    growth = new - carried @ old @ carried.T
    least = float(np.linalg.eigvalsh(growth)[0])
    if not growth.any() or least < -_ROUNDING * float(np.abs(new).max()):
        return None, "its pose covariance does not grow as a sum of steps does"
    if math.sqrt(float(np.diag(growth).max())) > _MOST_STD:
        return None, "its pose covariance grows beyond belief"
    turned = np.eye(3)
    turned[:2, :2] = rotation(-before.base_in_odom.theta)
    return turned @ growth @ turned.T, ""


def _fault(covariance: PlanarCovariance) -> str:
    """Return what keeps a twist's covariance from being one, empty if nothing does; a base may not move sideways."""
    names = ("forward", "sideways", "turn")
    for name, variance in zip(names, (covariance.xx, covariance.yy, covariance.tt), strict=True):
        least = 0.0 if name == "sideways" else _LEAST_STD**2
        if not least <= variance <= _MOST_STD**2:
            return f"has a variance {name} of {variance:g}, not {least:g} to {_MOST_STD**2:g}"
    matrix = covariance.matrix
    if not np.isfinite(matrix).all():
        return "holds what is no number"
    least_eigenvalue = float(np.linalg.eigvalsh(matrix)[0])
    if least_eigenvalue < -_ROUNDING * float(np.abs(matrix).max()):
        return f"is not positive: it has an eigenvalue of {least_eigenvalue:g}"
    return ""
