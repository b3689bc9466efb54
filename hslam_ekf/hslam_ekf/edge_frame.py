"""From the departure frame into the edge frame: the x axis turned through the terminal meet point (section III-A).

The angle is itself an estimate, phi = atan2 of the terminal, so the transformation's Jacobian has, besides
the rotation of every point, a column that moves every point with the terminal.
"""

import math

import numpy as np

from hslam_ekf.motion_model import ROBOT
from hslam_types.edge_map import TERMINAL_MIN_M
from hslam_types.se2 import Array, rotation, wrap


def turn_to_terminal(mean: Array, covariance: Array) -> tuple[Array, Array, float]:
    """Turn X = [robot | landmarks ... terminal] (last two entries: the terminal) so that x passes through the terminal.

    Returns the state and covariance in the edge frame and the angle phi (rad) turned by; the terminal's y and
    its rows of P become zero.  A terminal nearer than `TERMINAL_MIN_M` gives no direction: phi is then zero
    and its y is given up.
    """
    x, y = mean[-2:].tolist()
    turns = math.hypot(x, y) >= TERMINAL_MIN_M
    phi = math.atan2(y, x) if turns else 0.0
    turned = turn(mean, phi)
    jacobian = turn_jacobian(mean, phi, depends_on_terminal=turns)
    jacobian[-1] = 0.0
    turned[-1] = 0.0
    spread = jacobian @ covariance @ jacobian.T
    return turned, 0.5 * (spread + spread.T), phi


def turn(mean: Array, phi: float) -> Array:
    """Express X in a frame turned by ``phi`` (rad) about the common origin."""
    turned = mean.copy()
    back = rotation(phi)  # points as rows: p R(phi) is R(-phi) p
    turned[:2] = mean[:2] @ back
    turned[2] = wrap(mean[2] - phi)
    turned[ROBOT:] = (mean[ROBOT:].reshape(-1, 2) @ back).reshape(-1)
    return turned


def turn_jacobian(mean: Array, phi: float, *, depends_on_terminal: bool) -> Array:
    """Return the derivative of `turn` by X, where ``phi`` is the direction of X's last point if so said."""
    size = len(mean)
    points = np.concatenate((np.arange(2), np.arange(ROBOT, size))).reshape(-1, 2)
    jacobian = np.eye(size)
    jacobian[points[:, :, None], points[:, None, :]] = rotation(-phi)
    if depends_on_terminal:
        x, y = mean[-2:].tolist()
        by_terminal = np.array([-y, x]) / (x * x + y * y)
        turned = turn(mean, phi)
        by_angle = np.zeros(size)
        by_angle[points[:, 0]], by_angle[points[:, 1]] = turned[points[:, 1]], -turned[points[:, 0]]
        by_angle[2] = -1.0
        jacobian[:, -2:] += np.outer(by_angle, by_terminal)
    return jacobian
