"""The points (landmarks, corners, edges) near a place."""

import numpy as np

from hslam_sim.cells import CELL_RADIUS_M, Cells
from hslam_types.se2 import Array


class PointIndex:
    """Points of a world, found by cell: rows of x, y (m) and whatever else is known of them."""

    def __init__(self, points: Array, reach_m: float) -> None:
        """Index n x (2 + k) points for lookups that need everything within ``reach_m`` of a place."""
        self._points = points
        self._reach_m = reach_m + CELL_RADIUS_M
        self._cells = Cells(self._gather)

    def near(self, x: float, y: float) -> Array:
        """Return every point within reach of a place (and a few beyond), as rows in the given order."""
        return self._cells.around(x, y)

    def _gather(self, x: float, y: float) -> Array:
        off = np.abs(self._points[:, :2] - np.array([x, y]))
        near: Array = self._points[(off < self._reach_m).all(axis=1)]
        return near
