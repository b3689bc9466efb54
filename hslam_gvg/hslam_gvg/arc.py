"""What two sonar arcs say about each other: the heart of the arc transversal median.

An arc is the set of places an echo can have come from: part of a circle round the transducer.  Arcs of one
corner cross there, transversally (Choset, Nagatani and Lazar, "The arc-transversal median algorithm", 2003).
Arcs of one flat wall cross at small angles, if at all; but they have the wall as their common tangent, which
fixes where each one touches it (regions of constant depth, Leonard and Durrant-Whyte 1992).
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hslam_types.se2 import Array, wrap_all

Flags = npt.NDArray[np.bool_]

LEVERAGE = 0.12
"""Least distance between two echoes that give a wall's direction, by the range squared (1/m): range noise of 1 %
then moves the point along the wall by no more than some 15 cm."""
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
        return self.x + self.range_m * float(np.cos(azimuth)), self.y + self.range_m * float(np.sin(azimuth))


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
    dx, dy = old.x - new.x, old.y - new.y
    gap = np.sqrt(dx * dx + dy * dy)
    safe = np.where(gap > 1e-6, gap, 1.0)
    towards = np.arctan2(dy, dx)
    r, q = new.range_m, old.range_m

    # Crossing: law of cosines in the triangle transducer - transducer - intersection.
    cos_new = (r * r + gap * gap - q * q) / (2.0 * r * safe)
    real = (np.abs(cos_new) < 1.0) & (gap > 1e-6)
    half = np.arccos(np.clip(cos_new, -1.0, 1.0))
    side = np.where(wrap_all(new.axis - towards) >= 0.0, 1.0, -1.0)
    crossing = towards + side * half
    on_old = np.arctan2(r * np.sin(crossing) - dy, r * np.cos(crossing) - dx)
    transversal = np.abs(wrap_all(crossing - on_old)) > least_crossing
    crosses = (
        real
        & transversal
        & (np.abs(wrap_all(crossing - new.axis)) <= half_cone)
        & (np.abs(wrap_all(on_old - old.axis)) <= half_cone)
    )

    # Tangent: n . (c_old - c_new) = r_new - r_old for the unit normal n.
    cos_normal = (r - q) / safe
    tilt = np.arccos(np.clip(cos_normal, -1.0, 1.0))
    normal = towards + side * tilt
    heard = half_cone + WALL_SLACK
    wall_length = gap * np.sin(tilt)
    touches = (
        (np.abs(cos_normal) < 1.0)
        & (wall_length > np.maximum(least_step_m, LEVERAGE * r * r))
        & (np.abs(wrap_all(normal - new.axis)) <= heard)
        & (np.abs(wrap_all(normal - old.axis)) <= heard)
    )
    return Relations(crosses, crossing, on_old, touches, normal, wall_length)


def median_azimuth(azimuths: Array, axis: float) -> float:
    """Return the median (rad) of directions taken relative to ``axis``."""
    return axis + float(np.median(wrap_all(azimuths - axis)))
