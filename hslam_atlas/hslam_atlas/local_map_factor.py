"""One local map as one factor of a global estimate: where its far end and its points lie in its own frame, jointly.

What a local map knows is a Gaussian over all its entries.  Those that nobody else speaks of need no variables of their
own: to leave them out of mean and covariance is to marginalise them, exactly.  What the estimate makes of the others
then moves them, too (`conditioned`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import gtsam
import numpy as np

from hslam_types.se2 import SE2, Array, rotation, wrap


@dataclass(frozen=True, slots=True, eq=False)
class LocalMap:
    """The pose of a frame at the map's far end, and points, all in the map's own frame (m, rad)."""

    end: SE2
    points: Array
    """n x 2."""
    covariance: Array
    """(3 + 2n) x (3 + 2n): x, y, theta of the end, then the points; positive definite."""

    def marginal(self, points: Sequence[int]) -> "LocalMap":
        """Return what the map knows of its end and of some of its points."""
        rows = _rows(points)
        return LocalMap(self.end, self.points[list(points)].reshape(-1, 2), self.covariance[np.ix_(rows, rows)])

    def conditioned(self, end: SE2, points: Sequence[int], places: Array) -> Array:
        """Return all points (n x 2), given where the end and some of the points (``places``, k x 2) really lie."""
        rows = _rows(points)
        turn = wrap(end.theta - self.end.theta)
        moved = np.concatenate(
            ([end.x - self.end.x, end.y - self.end.y, turn], (places - self.points[list(points)]).ravel())
        )
        follows = self.covariance[3:, rows] @ np.linalg.solve(self.covariance[np.ix_(rows, rows)], moved)
        return self.points + follows.reshape(-1, 2)


def local_map_factor(frame: int, end: int, points: Sequence[int], local_map: LocalMap) -> gtsam.CustomFactor:
    """Return the factor a map is to the poses of its frame and of its end, and to its points (keys of all of them)."""
    expected = np.concatenate(([local_map.end[:2]], local_map.points))

    def error(this: gtsam.CustomFactor, values: gtsam.Values, jacobians: list[Array] | None) -> Array:
        keys = this.keys()
        pose, far = values.atPose2(keys[0]), values.atPose2(keys[1])
        places = np.array([[far.x(), far.y()], *(values.atPoint2(key) for key in keys[2:])])
        seen = (places - [pose.x(), pose.y()]) @ rotation(pose.theta())  # points as rows: p R is R^T p
        turn = far.theta() - pose.theta()
        if jacobians is not None:
            for index, jacobian in enumerate(_jacobians(seen, pose.theta(), turn)):
                jacobians[index] = jacobian
        off = seen - expected
        return np.concatenate((off[0], [wrap(turn - local_map.end.theta)], off[1:].ravel()))

    noise = gtsam.noiseModel.Gaussian.Covariance(local_map.covariance)
    return gtsam.CustomFactor(noise, [frame, end, *points], error)


def _jacobians(seen: Array, theta: float, turn: float) -> list[Array]:
    """Return the derivatives by frame, end and points; a pose's by an increment in its own frame, as GTSAM has it.

    ``seen``: end and points in the map's frame, (1 + n) x 2; ``theta``: its heading, ``turn``: the end's against it.
    """
    size = 1 + 2 * len(seen)
    rows = [0, *range(3, size, 2)]
    by_frame = np.zeros((size, 3))
    for row, (x, y) in zip(rows, seen.tolist(), strict=True):
        by_frame[row : row + 2] = [[-1.0, 0.0, y], [0.0, -1.0, -x]]
    by_frame[2, 2] = -1.0
    by_end = np.zeros((size, 3))
    by_end[:2, :2] = rotation(turn)
    by_end[2, 2] = 1.0
    found = [by_frame, by_end]
    for row in rows[1:]:
        by_point = np.zeros((size, 2))
        by_point[row : row + 2] = rotation(-theta)
        found.append(by_point)
    return found


def _rows(points: Sequence[int]) -> list[int]:
    """Return the rows of the end and of some points in a map's covariance."""
    return [0, 1, 2, *(row for point in points for row in (3 + 2 * point, 4 + 2 * point))]
