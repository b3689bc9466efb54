"""Which sighting is of which landmark: two gates on eq. 3 and the best joint assignment between them.

The assignment is global nearest neighbour (Blackman and Popoli, 1999): the gated pairs of one look that
together are most likely, each landmark seen at most once.  It differs from the paper's nearest landmark
for each sighting only where two sightings compete for one landmark.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from hslam_types.se2 import Array, wrap_all

Indices = npt.NDArray[np.intp]


class Association(NamedTuple):
    """The verdict on one look: indices into the sightings and into the landmarks predicted."""

    sightings: Indices
    """Sightings accepted, m."""
    landmarks: Indices
    """The landmark of each, m, no two alike."""
    fresh: Indices
    """Sightings too far from every landmark to be of one."""


def mahalanobis(sightings: Array, expected: Array, innovation: Array) -> Array:
    """Return chi of eq. 3 (m x k) of m sightings against k expected ones under S (m x k x 2 x 2)."""
    distance = sightings[:, None, 0] - expected[None, :, 0]
    bearing = wrap_all(sightings[:, None, 1] - expected[None, :, 1])
    rr, rb, bb = innovation[..., 0, 0], innovation[..., 0, 1], innovation[..., 1, 1]
    chi: Array = (bb * distance**2 - 2.0 * rb * distance * bearing + rr * bearing**2) / (rr * bb - rb**2)
    return chi


def associate(
    sightings: Array, noise: Array, expected: Array, spread: Array, *, accept_gate: float, new_gate: float
) -> Association:
    """Assign sightings (m x 2, variances ``noise`` m x 2) to landmarks ``expected`` (k x 2), each with its H P H^T."""
    innovation = np.repeat(spread[None], len(sightings), axis=0)
    innovation[..., 0, 0] += noise[:, None, 0]
    innovation[..., 1, 1] += noise[:, None, 1]
    chi = mahalanobis(sightings, expected, innovation)
    gated = chi < accept_gate
    fresh = np.flatnonzero((chi > new_gate).all(axis=1))
    if gated.sum(axis=0).max(initial=0) <= 1 and gated.sum(axis=1).max(initial=0) <= 1:
        rows, columns = np.nonzero(gated)
        return Association(rows, columns, fresh)
    determinant = innovation[..., 0, 0] * innovation[..., 1, 1] - innovation[..., 0, 1] ** 2
    # The log-determinant makes chi a likelihood: a vague landmark must not win merely by being vague.
    forbidden = 1e6
    rows, columns = linear_sum_assignment(np.where(gated, chi + np.log(determinant), forbidden))
    allowed = gated[rows, columns]
    return Association(rows[allowed], columns[allowed], fresh)
