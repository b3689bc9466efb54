"""Planar rigid motions and the arithmetic of angles (metres, radians, counter-clockwise positive).

``a_in_b`` names the pose of frame ``a`` expressed in frame ``b``; composition reads left to right:
``a_in_c = b_in_c @ a_in_b``.  Source: Smith, Self and Cheeseman, "Estimating uncertain spatial
relationships in robotics", 1990 (compounding and inverse).
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def wrap(angle: float) -> float:
    """Return ``angle`` (rad) brought into [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def wrap_all(angles: Array) -> Array:
    """Return ``angles`` (rad, any shape) brought into [-pi, pi)."""
    wrapped: Array = (angles + math.pi) % (2.0 * math.pi) - math.pi
    return wrapped


class SE2(NamedTuple):
    """The pose of one frame in another: x, y in metres, theta in radians."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def __matmul__(self, other: "SE2") -> "SE2":
        """Compose: with ``self = b_in_c`` and ``other = a_in_b``, return ``a_in_c``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return SE2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap(self.theta + other.theta),
        )

    def inverse(self) -> "SE2":
        """Return ``b_in_a`` for ``self = a_in_b``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return SE2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap(-self.theta))

    def to(self, other: "SE2") -> "SE2":
        """Return the pose of ``other`` seen from ``self``, both given in one frame."""
        return self.inverse() @ other

    def apply(self, x: float, y: float) -> tuple[float, float]:
        """Map one point (m) from this pose's own frame into the frame it is given in."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return self.x + c * x - s * y, self.y + s * x + c * y

    def apply_all(self, points: Array) -> Array:
        """Map ``points`` (n x 2, m) from this pose's own frame into the frame it is given in."""
        moved: Array = points @ rotation(self.theta).T + np.array([self.x, self.y])
        return moved


def rotation(theta: float) -> Array:
    """Return the 2 x 2 rotation by ``theta`` (rad)."""
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s], [s, c]])


def compose_jacobians(b_in_c: SE2, a_in_b: SE2) -> tuple[Array, Array]:
    """Return the 3 x 3 derivatives of ``b_in_c @ a_in_b`` by its left and by its right operand."""
    c, s = math.cos(b_in_c.theta), math.sin(b_in_c.theta)
    dx, dy = -s * a_in_b.x - c * a_in_b.y, c * a_in_b.x - s * a_in_b.y
    left = np.array([[1.0, 0.0, dx], [0.0, 1.0, dy], [0.0, 0.0, 1.0]])
    right = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return left, right


def inverse_jacobian(a_in_b: SE2) -> Array:
    """Return the 3 x 3 derivative of ``a_in_b.inverse()`` by ``a_in_b``."""
    c, s = math.cos(a_in_b.theta), math.sin(a_in_b.theta)
    back = a_in_b.inverse()
    return np.array([[-c, -s, back.y], [s, -c, -back.x], [0.0, 0.0, -1.0]])
