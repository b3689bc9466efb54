"""Edges among the echoes that no wall explains: a convex edge answers from all round, but three pings in ten at best.

What speaks against a wall, pings that went past along its normal, says little of an edge.  It is believed where several
pings from different places agree, and their share of all that listened to the place is not too small for one.
"""

import math

import numpy as np

from hslam_gvg.ranging.rolling_grid import Mask
from hslam_types.se2 import Array

EDGE_M = 2.0
"""An edge answers from this near at most."""
AGREEING = 3
"""Echoes that make an edge."""
FOR_ONE, AGAINST_ONE, LEAST = math.log(0.3 / 0.03), math.log(1.0 - 0.3), 2.0
"""Log odds of an edge that answers three pings in ten: by an echo that agrees (by chance three in a hundred do), by a
silent ping, and what they must add up to."""
SAME_M = 0.12
"""Candidates of agreeing echoes this near are averaged into the place."""
TOLERANCE_M, TOLERANCE_SHARE = 0.05, 0.02
"""A range agrees with a distance within these."""
RIM_SLACK = math.radians(1.0)
"""What lies this little outside the cone may answer: heading is known no better."""
SUSPECTED_M = 1.5
"""An echo from this near is minded before another agrees with it,"""
CLEARED = 8
"""until so many pings have listened to the place in vain: an edge is silent so often once in twenty times."""


def edges(candidates: Array, echoes: Array, silent: Array) -> tuple[Array, Mask]:
    """Return the places of edges (j x 2), the surest first, and which of the echoes (6 x n) they explain.

    ``candidates`` are 2 x n x k places on the echoes' arcs; ``silent`` (n x k) counts the pings that listened to each
    in vain.  An echo has one cause: what a sure edge explains is no evidence of another.
    """
    agrees = _agrees(candidates, echoes)
    left = np.ones(echoes.shape[1], bool)
    places: list[Array] = []
    while left.any():
        heard = np.count_nonzero(agrees[:, :, left], axis=2)
        odds = np.where(left[:, None] & (heard >= AGREEING), FOR_ONE * heard + AGAINST_ONE * silent, -math.inf)
        best = np.unravel_index(int(odds.argmax()), odds.shape)
        if odds[best] < LEAST:
            break
        place = candidates[:, best[0], best[1]]
        mine = left & agrees[best]
        near = np.hypot(*(candidates[:, mine] - place[:, None, None])) < SAME_M
        places.append(candidates[:, mine][:, near].mean(axis=1))
        left &= ~mine
    return np.array(places).reshape(-1, 2), ~left


def _agrees(candidates: Array, echoes: Array) -> Mask:
    """Return which echoes (last) agree with which candidates (first two); a candidate's own is one of them."""
    px, py = candidates[0][..., None], candidates[1][..., None]
    x, y, axis, heard, half, _ = echoes
    dx, dy = px - x, py - y
    distance = np.sqrt(dx * dx + dy * dy) + 1e-9
    in_cone = dx * np.cos(axis) + dy * np.sin(axis) > np.cos(half + RIM_SLACK) * distance
    agrees: Mask = in_cone & (np.abs(distance - heard) < TOLERANCE_M + TOLERANCE_SHARE * heard)
    return agrees


def suspicious(candidates: Array, ranges: Array, silent: Array) -> Array:
    """Return the places (j x 2) on near arcs that pings have not cleared yet; arguments as of `edges`."""
    doubted = (ranges < SUSPECTED_M)[:, None] & (silent < CLEARED)
    return np.column_stack((candidates[0][doubted], candidates[1][doubted]))
