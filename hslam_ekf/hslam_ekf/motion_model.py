"""The state transition f(X, U) of eq. 2: odometry as input, with slip and a constant rotation bias.

The robot's part of the state is (x, y, theta, bias).  The bias (rad per metre driven) is added to the
paper's eq. 1 because wheels of unequal size turn the odometry by a constant amount a metre: no white
noise describes that, and without the state the heading drifts by more than its covariance says.
A step that comes with its own covariance has no bias besides: all of its error is in that.
"""

import math

import numpy as np

from hslam_ekf.config import EkfConfig
from hslam_types.se2 import SE2, Array, wrap

ROBOT = 4
"""Length of the robot's part of the state: x, y (m), theta (rad), bias (rad/m)."""


def move(robot: Array, step: SE2, *, biased: bool = True) -> Array:
    """Return f: the robot (4) after an odometry ``step`` (the new base_link pose in the old one)."""
    x, y, theta, bias = robot.tolist()
    c, s = math.cos(theta), math.sin(theta)
    heading = theta + step.theta - bias * step.x if biased else theta + step.theta
    return np.array([x + c * step.x - s * step.y, y + s * step.x + c * step.y, wrap(heading), bias])


def move_jacobian(robot: Array, step: SE2, *, biased: bool = True) -> Array:
    """Return the 4 x 4 derivative of `move` by the robot."""
    c, s = math.cos(robot[2]), math.sin(robot[2])
    return np.array(
        [
            [1.0, 0.0, -s * step.x - c * step.y, 0.0],
            [0.0, 1.0, c * step.x - s * step.y, 0.0],
            [0.0, 0.0, 1.0, -step.x if biased else 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def stated_noise(robot: Array, noise: Array) -> Array:
    """Return Q (4 x 4) of a step whose covariance (3 x 3) is given in base_link as it was before the step."""
    c, s = math.cos(robot[2]), math.sin(robot[2])
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    spread: Array = turned @ noise @ turned.T
    return spread


def slip_noise(step: SE2, config: EkfConfig) -> Array:
    """Return Q (4 x 4) of one odometry step: a random walk in way and angle, so independent of the step's length."""
    way, turned = math.hypot(step.x, step.y), abs(step.theta)
    shift = config.slip_per_metre**2 * way
    turn = config.turn_slip_per_metre**2 * way + config.turn_slip_per_radian**2 * turned
    return np.diag([shift, shift, turn, 0.0])
