"""Update a stored edge-map by another drive along the same edge (section III-B, last paragraph).

The alignment's filter has already updated the landmarks and the terminal, which counts as one of them.  What is
left: landmarks only one drive knows, and the frame, turned so that x passes through the terminal again.

The paper also moves the origin by its share of the offset.  Here it stays where the first drive had it: every edge
end knows the pose of its frame in the node's, so nothing asks for the mean of the visits, and a covariance
means something only about a place that was once stood on.  Between visits the frame would hang in the air by
as much as meet points scatter, which is more than the landmarks' errors.
"""

import math
from dataclasses import replace

import numpy as np

from hslam_atlas.alignment import Alignment
from hslam_types.edge_map import TERMINAL_MIN_M, EdgeMap
from hslam_types.se2 import Array, rotation, wrap


def fuse(
    existing: EdgeMap, candidate: EdgeMap, alignment: Alignment, drives: tuple[int, int], *, forget_below: int
) -> tuple[EdgeMap, float]:
    """Return the updated map and the turn of its frame (rad); ``drives``: how many the old and the new map hold.

    ``alignment`` must be of exactly these two maps with their terminals tied. A landmark that the new drive did not
    see keeps a third of its sightings; it goes when fewer than ``forget_below`` are left.
    """
    points, covariance = _joined(existing, candidate, alignment)
    sightings = _sightings(existing, candidate, alignment)
    seen = {i for i, _ in alignment.pairs} | set(range(existing.size, len(sightings)))
    kept = np.array([i in seen or n >= forget_below for i, n in enumerate(sightings)], dtype=bool)
    rows = np.repeat(np.concatenate(([True], kept)), 2)
    points, covariance = points[rows[::2]], covariance[np.ix_(rows, rows)]
    points, covariance, turn = _turned(points, covariance)
    updated = replace(
        existing,
        terminal_x=float(points[0, 0]),
        landmarks=points[1:],
        covariance=covariance,
        sightings=tuple(int(n) for n, keep in zip(sightings, kept, strict=True) if keep),
        departure_heading=wrap(existing.departure_heading - turn),
        arrival_heading=wrap(existing.arrival_heading - turn),
        path_length_m=(existing.path_length_m * drives[0] + candidate.path_length_m * drives[1]) / sum(drives),
    )
    return updated, turn


def _joined(existing: EdgeMap, candidate: EdgeMap, alignment: Alignment) -> tuple[Array, Array]:
    """Return terminal, existing and new landmarks in the existing frame with their joint covariance."""
    paired = {j for _, j in alignment.pairs}
    fresh = [j for j in range(candidate.size) if j not in paired]
    known = 2 + 2 * existing.size
    size = known + 2 * len(fresh)
    jacobian = np.zeros((size, len(alignment.mean)))
    jacobian[:known, 3 : 3 + known] = np.eye(known)
    q = alignment.offset
    turn = rotation(q.theta)
    points = [alignment.mean[3 : 3 + known].reshape(-1, 2)]
    for n, j in enumerate(fresh):
        row, column = known + 2 * n, 3 + known + 2 + 2 * j
        point = turn @ alignment.mean[column : column + 2]
        points.append(np.array([[point[0] + q.x, point[1] + q.y]]))
        jacobian[row : row + 2, :2] = np.eye(2)
        jacobian[row : row + 2, 2] = [-point[1], point[0]]
        jacobian[row : row + 2, column : column + 2] = turn
    return np.concatenate(points), jacobian @ alignment.covariance() @ jacobian.T


def _sightings(existing: EdgeMap, candidate: EdgeMap, alignment: Alignment) -> list[int]:
    """Return how often each landmark of `_joined` counts as seen."""
    partner = dict(alignment.pairs)
    known = [n + candidate.sightings[partner[i]] if i in partner else n // 3 for i, n in enumerate(existing.sightings)]
    paired = set(partner.values())
    return known + [n for j, n in enumerate(candidate.sightings) if j not in paired]


def _turned(points: Array, covariance: Array) -> tuple[Array, Array, float]:
    """Turn points so that the first lies on x; the angle depends on it, and so does the covariance.

    As at the EKF level, a terminal too near to give a direction turns nothing, and its y is given up.
    """
    x, y = points[0].tolist()
    turns = math.hypot(x, y) >= TERMINAL_MIN_M
    phi = math.atan2(y, x) if turns else 0.0
    turned = points @ rotation(phi)  # points as rows: p R(phi) is R(-phi) p
    jacobian = np.kron(np.eye(len(points)), rotation(-phi))
    if turns:
        by_angle = np.column_stack((turned[:, 1], -turned[:, 0])).reshape(-1)
        jacobian[:, :2] += np.outer(by_angle, np.array([-y, x]) / (x * x + y * y))
    jacobian[1] = 0.0
    turned[0, 1] = 0.0
    spread = jacobian @ covariance @ jacobian.T
    return turned, 0.5 * (spread + spread.T), phi
