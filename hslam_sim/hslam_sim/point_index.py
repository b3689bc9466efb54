"""The points (landmarks, corners, edges) near a place."""

import numpy as np
from hslam_types.se2 import Array

from hslam_sim.cells import CELL_RADIUS_M, Cells


class PointIndex:
    """Points of a world (n x 2, m), found by cell."""

    def __init__(self, points: Array, reach_m: float) -> None:
        """Index points for lookups that need everything within ``reach_m`` of a place."""
        self._points = points
        self._reach_m = reach_m + CELL_RADIUS_M
        self._cells = Cells(self._gather)

    def near(self, x: float, y: float) -> Array:
        """Return every point within reach of a place (and a few beyond), k x 2, in the given order."""
        return self._cells.around(x, y)

    def _gather(self, x: float, y: float) -> Array:
        off = np.abs(self._points - np.array([x, y]))
        return self._points[(off < self._reach_m).all(axis=1)]
