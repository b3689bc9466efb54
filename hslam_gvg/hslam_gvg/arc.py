"""What two sonar arcs say about each other: the heart of the arc transversal median.

An arc is the set of places an echo can have come from: part of a circle round the transducer.  Arcs of one
corner cross there, transversally (Choset, Nagatani and Lazar, "The arc-transversal median algorithm", 2003).
Arcs of one flat wall cross at small angles, if at all; but they have the wall as their common tangent, which
fixes where each one touches it (regions of constant depth, Leonard and Durrant-Whyte 1992).
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hslam_types.se2 import Array, wrap_all

Flags = npt.NDArray[np.bool_]

LEVERAGE = 0.12
"""Least distance between two echoes that give a wall's direction, by the range squared (1/m): range noise of 1 %
then moves the point along the wall by no more than some 15 cm."""
SAME_FACE_M = 1e-6
"""Transducers nearer than this are in one place."""
WALL_SLACK = 0.4
"""How far (rad) outside the cone a wall's normal may lie; the cone's edge then hears the wall (Polaroids do)."""


class Arc(NamedTuple):
    """One echo, in odom: the transducer's face (m), its axis (rad) and the range from the face (m)."""

    x: float
    y: float
    axis: float
    range_m: float

    def point(self, azimuth: float) -> tuple[float, float]:
        """Return the point (m) of the arc's circle in a direction (rad)."""
        return self.x + self.range_m * math.cos(azimuth), self.y + self.range_m * math.sin(azimuth)


class Arcs(NamedTuple):
    """Many arcs, one array (n) a field of `Arc`."""

    x: Array
    y: Array
    axis: Array
    range_m: Array


class Relations(NamedTuple):
    """One new arc against n older ones; azimuths (rad) are meaningless where the flag is False."""

    crosses: Flags
    crossing: Array
    """Azimuth of the transversal intersection on the new arc (n)."""
    crossing_on_old: Array
    touches: Flags
    normal: Array
    """Azimuth of the common wall's normal, from the transducers (n)."""
    wall_length: Array
    """Distance between the two touching points (m)."""


def relate(new: Arc, old: Arcs, half_cone: float, least_crossing: float, least_step_m: float) -> Relations:
    """Intersect a new arc with older ones and draw their common tangents.

    A crossing counts within both cones at more than ``least_crossing`` (rad); a tangent needs transducers at
    least ``least_step_m`` apart and a normal that both cones can hear.
    """
    # Unit vectors throughout: along the base (u), the axes (a, b), and the directions sought, as cosine pairs.
    dx, dy = old.x - new.x, old.y - new.y
    gap = np.maximum(np.sqrt(dx * dx + dy * dy), SAME_FACE_M)
    ux, uy = dx / gap, dy / gap
    r, q = new.range_m, old.range_m
    ax, ay = math.cos(new.axis), math.sin(new.axis)
    bx, by = np.cos(old.axis), np.sin(old.axis)

    # Cosine between u and the crossing p (law of cosines in the triangle transducer - transducer - intersection),
    # and between u and the tangent's normal n (n . (c_old - c_new) = r_new - r_old).
    cosine = np.array(((r * r + gap * gap - q * q) / (2.0 * r * gap), (r - q) / gap))
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    wall_length = gap * sine[1]
    # The solution on the side of the base that the new sonar looks to.
    sine *= np.where(ux * ay - uy * ax >= 0.0, 1.0, -1.0)
    towards_x, towards_y = cosine * ux - sine * uy, cosine * uy + sine * ux
    px, py = towards_x[0], towards_y[0]
    ox, oy = (r * px - dx) / q, (r * py - dy) / q
    on_axis = towards_x * ax + towards_y * ay

    least, heard = math.cos(half_cone), math.cos(half_cone + WALL_SLACK)
    crosses = np.abs(cosine[0]) < 1.0
    crosses &= px * ox + py * oy < math.cos(least_crossing)
    crosses &= (on_axis[0] >= least) & (ox * bx + oy * by >= least)
    touches = wall_length > max(least_step_m, LEVERAGE * r * r)
    touches &= (on_axis[1] >= heard) & (towards_x[1] * bx + towards_y[1] * by >= heard)
    azimuth = np.arctan2(towards_y, towards_x)
    return Relations(crosses, azimuth[0], np.arctan2(oy, ox), touches, azimuth[1], wall_length)


def median_azimuth(azimuths: Array, axis: float) -> float:
    """Return the median (rad) of directions taken relative to ``axis``."""
    offsets: list[float] = sorted(wrap_all(azimuths - axis).tolist())
    middle = len(offsets) // 2
    return axis + (offsets[middle] if len(offsets) % 2 else 0.5 * (offsets[middle - 1] + offsets[middle]))
