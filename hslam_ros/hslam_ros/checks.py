"""What every message must hold before anything of it is used; each check raises MessageError with the field's name.

The bounds are wide: they keep out what no robot on a floor can have measured, and what squares and differences of
would no longer be numbers, or positive.
"""

import math
from collections.abc import Iterable, Sized
from enum import IntEnum
from typing import TypeVar

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion

from hslam_ros.stamps import NS_PER_S, stamp_from_msg
from hslam_types.errors import MessageError
from hslam_types.se2 import Array

K = TypeVar("K", bound=IntEnum)

LARGEST = 1e6
"""Largest length (m), angle (rad) or speed."""
FARTHEST_M = 1e3
"""Largest range of a sensor."""
LEAST_RANGE_M = 1e-3
"""Least range of a landmark: nearer it has no bearing."""
LEAST_STD = 1e-4
"""Least standard deviation of a sighting (m, rad): the square of less drowns in the rounding of a map's covariance."""
NORM_TOLERANCE = 0.01
"""How far the squared norm of a quaternion may be from 1; tf2 asks for the same."""
COVARIANCE_TOLERANCE = 1e-6
"""How far a covariance may be from symmetric and positive by rounding, as a share of its largest entry."""


def number(value: float, field: str, low: float = -LARGEST, high: float = LARGEST) -> float:
    """Return a number between ``low`` and ``high``, which NaN is not."""
    if not low <= value <= high:
        raise MessageError(f"{field} = {value:g} is no number from {low:g} to {high:g}")
    return value


def numbers(values: Iterable[float], field: str, low: float = -LARGEST, high: float = LARGEST) -> tuple[float, ...]:
    """Return numbers that are all between ``low`` and ``high``."""
    return tuple(number(value, f"{field}[{i}]", low, high) for i, value in enumerate(values))


def echo(range_m: float, field: str) -> float:
    """Return the range of a ping: not negative, +inf where nothing answered (REP-117)."""
    return range_m if range_m == math.inf else number(range_m, field, 0.0, FARTHEST_M)


def same_length(**fields: Sized) -> None:
    """Refuse columns of one table that are not equally long."""
    if len({len(column) for column in fields.values()}) > 1:
        raise MessageError("unequal lengths: " + ", ".join(f"{name} {len(column)}" for name, column in fields.items()))


def index(value: int, field: str, count: int, low: int = 0) -> int:
    """Return an index below ``count``; ``low`` -1 where that stands for "unknown"."""
    if not low <= value < count:
        raise MessageError(f"{field} = {value} is no index of {count}")
    return value


def kind_of(kinds: type[K], value: int, field: str) -> K:
    """Return a constant as what it stands for."""
    try:
        return kinds(value)
    except ValueError as error:
        raise MessageError(f"{field} = {value} is unknown") from error


def stamp(msg: Time, field: str = "header.stamp") -> int:
    """Return a stamp in nanoseconds; time begins at 0."""
    if msg.sec < 0 or msg.nanosec >= NS_PER_S:
        raise MessageError(f"{field} = {msg.sec} s {msg.nanosec} ns is no time")
    return stamp_from_msg(msg)


def rotation(q: Quaternion, field: str) -> Quaternion:
    """Return a quaternion that is a rotation."""
    squared = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w
    number(squared, f"squared norm of {field}", 1.0 - NORM_TOLERANCE, 1.0 + NORM_TOLERANCE)
    return q


def covariance(values: Iterable[float], field: str, size: int) -> Array:
    """Return a covariance (size x size) given row by row: symmetric and positive semi-definite but for rounding."""
    flat = np.fromiter(values, dtype=np.float64)
    if flat.size != size * size:
        raise MessageError(f"{field} has {flat.size} entries, not {size} x {size}")
    if not np.all(np.abs(flat) <= LARGEST**2):
        raise MessageError(f"{field} holds entries that are no numbers up to {LARGEST**2:g}")
    matrix: Array = flat.reshape(size, size)
    rounding = COVARIANCE_TOLERANCE * float(np.abs(matrix).max(initial=0.0))
    if np.abs(matrix - matrix.T).max(initial=0.0) > rounding:
        raise MessageError(f"{field} is not symmetric")
    least = float(np.linalg.eigvalsh(matrix).min(initial=0.0))
    if least < -rounding:
        raise MessageError(f"{field} is not positive semi-definite: it has an eigenvalue of {least:g}")
    return matrix
