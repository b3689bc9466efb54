"""The GVG control laws, as the equations read.

With d_i the distance to obstacle i and grad d_i its unit gradient (Choset and Nagatani 2001):
access  v = grad d_1;   trace  v = alpha null(grad G) - beta pinv(grad G) G,  G = d_1 - d_2;
home    v = -beta pinv(grad G) G,  G = [d_1 - d_2, d_1 - d_3, ...].
All velocities are in odom (m/s).
"""

import math
from collections.abc import Sequence

import numpy as np

from hslam_gvg.closest_points import ClosestPoint
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity

Vector = tuple[float, float]
TURN_GAIN = 2.5
"""Rate of turn by error of heading (1/s); with odometry at 8 Hz the loop stays well damped."""
TURN_FIRST = math.radians(50.0)
"""Beyond this error the robot turns on the spot: driving on would leave equidistance farther than turning costs."""


def access(nearest: ClosestPoint, speed: float) -> Vector:
    """Ascend d_1."""
    gx, gy = nearest.gradient
    return speed * gx, speed * gy


def trace(first: ClosestPoint, second: ClosestPoint, heading: float, alpha: float, beta: float) -> Vector:
    """Follow d_1 = d_2 the way nearer to ``heading`` (rad) at speed ``alpha`` (m/s) with gain ``beta`` (1/s)."""
    g = first.distance_m - second.distance_m
    (ax, ay), (bx, by) = first.gradient, second.gradient
    jx, jy = ax - bx, ay - by
    norm = math.hypot(jx, jy)
    if norm < 1e-6:
        return alpha * math.cos(heading), alpha * math.sin(heading)
    null_x, null_y = -jy / norm, jx / norm
    if null_x * math.cos(heading) + null_y * math.sin(heading) < 0.0:
        null_x, null_y = -null_x, -null_y
    # pinv of a row vector J is J^T / |J|^2.
    back = -beta * g / (norm * norm)
    return alpha * null_x + back * jx, alpha * null_y + back * jy


def follow(wall: ClosestPoint, distance_m: float, heading: float, alpha: float, beta: float) -> Vector:
    """Follow one wall at a set distance (m): G = d_1 - distance, for places too wide for two."""
    gx, gy = wall.gradient
    null_x, null_y = -gy, gx
    if null_x * math.cos(heading) + null_y * math.sin(heading) < 0.0:
        null_x, null_y = -null_x, -null_y
    back = -beta * (wall.distance_m - distance_m)
    return alpha * null_x + back * gx, alpha * null_y + back * gy


def home(obstacles: Sequence[ClosestPoint], beta: float) -> Vector:
    """Go to where three or more obstacles are equally far; for two, to the nearest point of equidistance."""
    first = obstacles[0]
    g = np.array([first.distance_m - other.distance_m for other in obstacles[1:]])
    jacobian = np.array([np.subtract(first.gradient, other.gradient) for other in obstacles[1:]])
    v = -beta * (np.linalg.pinv(jacobian, rcond=0.15) @ g)
    return float(v[0]), float(v[1])


def drive(base_in_odom: SE2, vx: float, vy: float, fastest_turn: float, backwards: bool = False) -> Velocity:
    """Turn a velocity in odom into a differential drive's command; turns on the spot first where it points aside."""
    speed = math.hypot(vx, vy)
    if speed < 1e-6:
        return Velocity()
    error = wrap(math.atan2(vy, vx) - base_in_odom.theta + (math.pi if backwards else 0.0))
    turn = max(-fastest_turn, min(fastest_turn, TURN_GAIN * error))
    forward = speed * math.cos(error) if abs(error) < TURN_FIRST else 0.0
    return Velocity(-forward if backwards else forward, turn)
