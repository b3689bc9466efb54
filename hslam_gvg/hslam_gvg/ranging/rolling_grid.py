"""A square of cells that rolls along with the robot: what is known free, what is an obstacle, what nobody has seen.

Cells lie on a lattice fixed in odom, so that nothing is resampled when the square moves.
"""

import math

import cv2
import numpy as np
import numpy.typing as npt

from hslam_types.se2 import Array

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
Cells = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

SUBCELL = 4
"""Binary digits of a cell's fraction in which OpenCV takes a polygon's corners."""
ROLL_AFTER_CELLS = 20
"""The square moves in strides: each one copies the whole grid."""


class RollingGrid:
    """States of cells, and in every occupied one the obstacle point last put there; positions in metres, odom."""

    def __init__(self, cell_m: float, half_m: float) -> None:
        """Begin with nothing known, about the origin."""
        self.cell_m = cell_m
        self.size = 2 * round(half_m / cell_m)
        self.state = np.zeros((self.size, self.size), np.uint8)
        """By row (y) and column (x)."""
        self.seen_m = np.full((self.size, self.size), -math.inf)
        """Odometer reading at which each cell was last seen."""
        self._point_x, self._point_y = np.zeros((2, self.size, self.size))
        self.column_0 = self.row_0 = -(self.size // 2)
        """The lattice's numbers of the lower left cell."""

    def cells(self, x: Array, y: Array) -> tuple[Cells, Cells, Mask]:
        """Return rows and columns of points within the square, and which of the points those are."""
        column = np.floor(x / self.cell_m).astype(np.int64) - self.column_0
        row = np.floor(y / self.cell_m).astype(np.int64) - self.row_0
        inside = (column >= 0) & (column < self.size) & (row >= 0) & (row < self.size)
        return row[inside], column[inside], inside

    def follow(self, x: float, y: float) -> None:
        """Keep a point near the middle of the square; what falls off the edge is forgotten."""
        right = math.floor(x / self.cell_m) - (self.column_0 + self.size // 2)
        up = math.floor(y / self.cell_m) - (self.row_0 + self.size // 2)
        if max(abs(right), abs(up)) <= ROLL_AFTER_CELLS:
            return
        self.column_0 += right
        self.row_0 += up
        grids = (self.state, UNKNOWN), (self.seen_m, -math.inf), (self._point_x, 0.0), (self._point_y, 0.0)
        for grid, empty in grids:
            _roll(grid, right, up, empty)

    def free(self, mask: Mask, odometer_m: float) -> None:
        """Note that the cells of a mask were seen to be free."""
        self.state[mask] = FREE
        self.seen_m[mask] = odometer_m

    def free_inside(self, corners: Array, odometer_m: float) -> None:
        """Note that the cells within a convex polygon (n x 2, m) were seen to be free; obstacles there go."""
        scaled = corners / self.cell_m - np.array([self.column_0 + 0.5, self.row_0 + 0.5])
        low = np.maximum(np.floor(scaled.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(scaled.max(axis=0)).astype(int) + 1, self.size)
        if (high <= low).any():
            return
        mask = np.zeros((high[1] - low[1], high[0] - low[0]), np.uint8)
        fixed = np.round((scaled - low) * 2**SUBCELL).astype(np.int32)
        cv2.fillConvexPoly(mask, fixed, 1, lineType=cv2.LINE_8, shift=SUBCELL)
        box, inside = np.s_[low[1] : high[1], low[0] : high[0]], mask.astype(bool)
        self.state[box][inside] = FREE
        self.seen_m[box][inside] = odometer_m

    def occupy(self, points: Array, odometer_m: float) -> None:
        """Note obstacle points (n x 2)."""
        row, column, inside = self.cells(points[:, 0], points[:, 1])
        self.state[row, column] = OCCUPIED
        self.seen_m[row, column] = odometer_m
        self._point_x[row, column], self._point_y[row, column] = points[inside, 0], points[inside, 1]

    def forget_before(self, odometer_m: float) -> None:
        """Forget what was last seen before an odometer reading."""
        self.state[self.seen_m < odometer_m] = UNKNOWN

    def obstacle_points(self) -> Array:
        """Return the point of every occupied cell, n x 2."""
        occupied = self.state == OCCUPIED
        return np.column_stack((self._point_x[occupied], self._point_y[occupied]))

    def is_free(self, x: Array, y: Array) -> Mask:
        """Return which points lie in cells known to be free."""
        return self.contains(self.state == FREE, x, y)

    def contains(self, mask: Mask, x: Array, y: Array) -> Mask:
        """Return which points lie in the cells of a mask (by row and column, as the square lies now)."""
        row, column, inside = self.cells(x, y)
        within = np.zeros(len(x), bool)
        within[inside] = mask[row, column]
        return within

    def free_and_far(self, distance_m: float) -> Mask:
        """Return which cells are known to be free and farther than a distance from every obstacle."""
        free = self.state == FREE
        occupied = self.state == OCCUPIED
        if not occupied.any():
            return np.asarray(free)
        away = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        return np.asarray(free & (away * self.cell_m > distance_m))

    def outline(self, mask: Mask) -> Array:
        """Return the middles (n x 2, m) of those cells of a mask that have a neighbour outside it."""
        found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        cells = np.concatenate([contour[:, 0] for contour in found]) if found else np.zeros((0, 2))
        outline: Array = (cells + np.array([self.column_0 + 0.5, self.row_0 + 0.5])) * self.cell_m
        return outline


def _roll(grid: npt.NDArray[np.generic], right: int, up: int, empty: float) -> None:
    """Move what a grid shows by whole cells in place; the new cells are empty."""
    size = len(grid)
    kept = np.full_like(grid, empty)
    to_rows, from_rows = _overlap(size, up)
    to_columns, from_columns = _overlap(size, right)
    kept[to_rows, to_columns] = grid[from_rows, from_columns]
    grid[...] = kept


def _overlap(size: int, shift: int) -> tuple[slice, slice]:
    """Return where cells go and where they come from along one axis; nothing where all of them fall off."""
    shift = max(-size, min(size, shift))
    return slice(max(0, -shift), min(size, size - shift)), slice(max(0, shift), min(size, size + shift))
