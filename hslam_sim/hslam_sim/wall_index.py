"""The walls near a point, ready for ray casting: what every simulated sensor looks through.

Walls are directed segments with free space on their left.  Only elementwise arithmetic is used: unlike a BLAS product
or a vectorised sine, it gives the same bits on every processor.
"""

import numpy as np
import numpy.typing as npt

from hslam_sim.cells import CELL_RADIUS_M, Cells
from hslam_types.se2 import Array

BEHIND_M = 0.01
"""How far behind a wall's face a sensor may sit and still see the wall (contact leaves rounding)."""
WORTH_CULLING = 64
"""So few walls are cast against faster than they are sorted out."""


class Walls:
    """Directed segments as columns of length n (m): start, unit tangent and length; free space is on the left."""

    __slots__ = ("_columns", "length", "start_x", "start_y", "tangent_x", "tangent_y")

    def __init__(self, columns: Array) -> None:
        """Take 5 x n: start x, start y, tangent x, tangent y, length."""
        self._columns = columns
        self.start_x, self.start_y, self.tangent_x, self.tangent_y, self.length = columns

    @classmethod
    def from_segments(cls, segments: Array) -> "Walls":
        """Build from n x 4 rows (x1, y1, x2, y2); segments of no length are left out."""
        dx, dy = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
        length = np.sqrt(dx * dx + dy * dy)
        real = length > 0.0
        dx, dy, length, segments = dx[real], dy[real], length[real], segments[real]
        return cls(np.stack([segments[:, 0], segments[:, 1], dx / length, dy / length, length]))

    def take(self, kept: npt.NDArray[np.bool_]) -> "Walls":
        """Return the walls where a mask of length n holds."""
        return Walls(self._columns.compress(kept, axis=1))

    def facing(self, x: float, y: float, reach_m: float) -> "Walls":
        """Return the walls whose face looks at a point and whose line passes within ``reach_m``, where that pays."""
        if len(self.length) < WORTH_CULLING:
            return self
        ahead = (self.start_x - x) * self.tangent_y - (self.start_y - y) * self.tangent_x
        return self.take((ahead > -BEHIND_M) & (ahead < reach_m))

    def within_wedge(self, x: float, y: float, right: tuple[float, float], left: tuple[float, float]) -> "Walls":
        """Return the walls that may reach into the wedge (under 180 deg) between two directions, where that pays."""
        if len(self.length) < WORTH_CULLING:
            return self
        start_x, start_y = self.start_x - x, self.start_y - y
        end_x, end_y = start_x + self.length * self.tangent_x, start_y + self.length * self.tangent_y
        beyond_right = np.maximum(right[0] * start_y - right[1] * start_x, right[0] * end_y - right[1] * end_x)
        beyond_left = np.maximum(left[1] * start_x - left[0] * start_y, left[1] * end_x - left[0] * end_y)
        return self.take(np.minimum(beyond_right, beyond_left) >= 0.0)

    def cast(self, x: float, y: float, ray_x: Array, ray_y: Array) -> tuple[Array, Array]:
        """Return, for m unit rays from a point, the distance to the first face hit and the cosine of incidence.

        Both have length m; where the distance is +inf nothing is hit and the cosine means nothing.
        """
        if not len(self.length):
            return np.full(len(ray_x), np.inf), np.zeros(len(ray_x))
        off_x, off_y = self.start_x - x, self.start_y - y
        ahead = off_x * self.tangent_y - off_y * self.tangent_x
        column_x, column_y = ray_x[:, None], ray_y[:, None]
        cosine = column_x * self.tangent_y - column_y * self.tangent_x
        along = off_x * column_y - off_y * column_x
        hit = (cosine > 1e-9) & (along >= 0.0) & (along <= self.length * cosine) & (ahead > -BEHIND_M)
        distance = np.full(hit.shape, np.inf)
        np.divide(np.maximum(ahead, 0.0), cosine, out=distance, where=hit)
        first = distance.argmin(axis=1)
        rows = np.arange(len(first))
        return distance[rows, first], cosine[rows, first]

    def clearance(self, x: float, y: float) -> float:
        """Return the distance (m) from a point to the nearest wall, +inf without walls."""
        if not len(self.length):
            return float("inf")
        off_x, off_y = x - self.start_x, y - self.start_y
        along = np.minimum(np.maximum(off_x * self.tangent_x + off_y * self.tangent_y, 0.0), self.length)
        dx, dy = off_x - along * self.tangent_x, off_y - along * self.tangent_y
        return float(np.sqrt((dx * dx + dy * dy).min()))


class WallIndex:
    """All walls of a world, found by cell."""

    def __init__(self, segments: Array, reach_m: float) -> None:
        """Index n x 4 segments (m) for lookups that need everything within ``reach_m`` of a point."""
        self.walls = Walls.from_segments(segments)
        self._reach_m = reach_m + CELL_RADIUS_M
        end_x = self.walls.start_x + self.walls.length * self.walls.tangent_x
        end_y = self.walls.start_y + self.walls.length * self.walls.tangent_y
        self._low_x, self._high_x = np.minimum(self.walls.start_x, end_x), np.maximum(self.walls.start_x, end_x)
        self._low_y, self._high_y = np.minimum(self.walls.start_y, end_y), np.maximum(self.walls.start_y, end_y)
        self._cells = Cells(self._gather)

    def near(self, x: float, y: float) -> Walls:
        """Return every wall within reach of a point (and a few beyond), in the world's order."""
        return self._cells.around(x, y)

    def _gather(self, x: float, y: float) -> Walls:
        reach = self._reach_m
        boxed = (self._high_x > x - reach) & (self._low_x < x + reach)
        boxed &= (self._high_y > y - reach) & (self._low_y < y + reach)
        return self.walls.take(boxed)
