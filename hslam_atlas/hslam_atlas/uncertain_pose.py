"""A pose with its covariance, and how both compose (Smith, Self and Cheeseman, 1990)."""

import math
from dataclasses import dataclass

import numpy as np

from hslam_types.se2 import SE2, Array, compose_jacobians, inverse_jacobian


@dataclass(frozen=True, slots=True, eq=False)
class UncertainPose:
    """The pose of one frame in another with its 3 x 3 covariance over x, y (m), theta (rad)."""

    pose: SE2
    covariance: Array

    @classmethod
    def exact(cls, pose: SE2) -> "UncertainPose":
        """Return a pose known without error."""
        return cls(pose, np.zeros((3, 3)))

    @classmethod
    def diagonal(cls, pose: SE2, position_std_m: float, heading_std: float) -> "UncertainPose":
        """Return a pose with independent errors of position (both axes alike) and heading."""
        return cls(pose, np.diag([position_std_m**2, position_std_m**2, heading_std**2]))

    def __matmul__(self, other: "UncertainPose") -> "UncertainPose":
        """Compose ``b_in_c @ a_in_b`` to ``a_in_c``, the two being independent."""
        left, right = compose_jacobians(self.pose, other.pose)
        covariance = left @ self.covariance @ left.T + right @ other.covariance @ right.T
        return UncertainPose(self.pose @ other.pose, covariance)

    def inverse(self) -> "UncertainPose":
        """Return the same relation seen from the other frame."""
        jacobian = inverse_jacobian(self.pose)
        return UncertainPose(self.pose.inverse(), jacobian @ self.covariance @ jacobian.T)

    def inflated(self, factor: float) -> "UncertainPose":
        """Return the pose with its standard deviations multiplied by ``factor``."""
        return UncertainPose(self.pose, self.covariance * factor**2)

    def heading_std(self) -> float:
        """Return the standard deviation of theta (rad)."""
        return math.sqrt(max(float(self.covariance[2, 2]), 0.0))
