"""A floor of corridors as a graph, with landmarks on both walls of each, for tests at the level of events."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Point = tuple[float, float]

SIGHT_M = 6.0
"""Range of the landmark sensor."""


@dataclass(frozen=True)
class Corridor:
    """An edge: its centre line from node ``start`` to node ``stop`` and its width (m)."""

    start: int
    stop: int
    line: tuple[Point, ...]
    width: float


@dataclass(frozen=True, eq=False)
class CorridorFloor:
    """Nodes are the ends of the corridors; a node with one corridor is a dead end."""

    corridors: tuple[Corridor, ...]
    landmarks: Array
    """n x 2, m, on the walls."""

    @cached_property
    def nodes(self) -> dict[int, Point]:
        """Position of every node."""
        places: dict[int, Point] = {}
        for corridor in self.corridors:
            places[corridor.start] = corridor.line[0]
            places[corridor.stop] = corridor.line[-1]
        return places

    def leaving(self, node: int) -> list[tuple[int, float, tuple[Point, ...], int]]:
        """Return (corridor index, direction, line from here, node it leads to), counter-clockwise."""
        found = []
        for index, corridor in enumerate(self.corridors):
            for here, there, line in (
                (corridor.start, corridor.stop, corridor.line),
                (corridor.stop, corridor.start, corridor.line[::-1]),
            ):
                if here == node:
                    bearing = math.atan2(line[1][1] - line[0][1], line[1][0] - line[0][0])
                    found.append((index, bearing, line, there))
        return sorted(found, key=lambda entry: entry[1])

    @cached_property
    def _segments(self) -> Array:
        """Rows x1, y1, x2, y2, half width."""
        rows = [
            (*a, *b, corridor.width / 2.0)
            for corridor in self.corridors
            for a, b in zip(corridor.line, corridor.line[1:], strict=False)
        ]
        return np.array(rows)

    def inside(self, points: Array, margin: float = 0.02) -> npt.NDArray[np.bool_]:
        """Whether points (n x 2) lie in free space: squares round every corner included."""
        x, y = points[:, 0, None], points[:, 1, None]
        x1, y1, x2, y2, half = self._segments.T
        low_x, high_x = np.minimum(x1, x2) - half, np.maximum(x1, x2) + half
        low_y, high_y = np.minimum(y1, y2) - half, np.maximum(y1, y2) + half
        within = (x > low_x - margin) & (x < high_x + margin) & (y > low_y - margin) & (y < high_y + margin)
        return np.asarray(within.any(axis=1))

    def visible_along(self, path: Array) -> npt.NDArray[np.intp]:
        """Return the indices of landmarks seen from some point of a path (k x 2)."""
        seen = np.zeros(len(self.landmarks), dtype=bool)
        steps = np.linspace(0.0, 0.98, 25)
        for position in path:
            near = np.flatnonzero(~seen & (np.hypot(*(self.landmarks - position).T) < SIGHT_M))
            if len(near):
                rays = position + steps[:, None, None] * (self.landmarks[near] - position)
                free = self.inside(rays.reshape(-1, 2)).reshape(len(steps), len(near)).all(axis=0)
                seen[near[free]] = True
        return np.flatnonzero(seen)


def furnish(
    corridors: tuple[Corridor, ...], rng: np.random.Generator, *, period_m: float = 0.0, gap_m: float = 1.0
) -> CorridorFloor:
    """Hang landmarks on the walls of axis-parallel corridors, ``gap_m`` apart on average.

    With ``period_m`` every straight stretch repeats one pattern: places that look alike.
    """
    bare = CorridorFloor(corridors, np.zeros((0, 2)))
    pattern = np.cumsum(0.6 + rng.exponential(0.4, size=400))
    points: list[Point] = []
    for corridor in corridors:
        for a, b in zip(corridor.line, corridor.line[1:], strict=False):
            length = math.dist(a, b)
            ux, uy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
            for side in (-1.0, 1.0):
                gaps = gap_m * (0.6 + rng.exponential(0.4, size=int(length) * 2 + 8))
                along = np.cumsum(gaps) - corridor.width / 2.0
                if period_m:
                    whole = [k * period_m + s for k in range(99) for s in pattern[pattern < period_m - 0.3].tolist()]
                    along = np.array(whole)
                for s in along[along < length + corridor.width / 2.0].tolist():
                    off = side * corridor.width / 2.0
                    points.append((a[0] + ux * s - uy * off, a[1] + uy * s + ux * off))
    cloud = np.array(points).reshape(-1, 2)
    return CorridorFloor(corridors, cloud[~bare.inside(cloud, margin=-0.02)])


def wean_hall() -> tuple[Corridor, ...]:
    """Return a floor like the paper's: 13 nodes (4 dead ends, a four-way, 8 three-ways), 16 edges, 4 cycles."""
    east, four = (98.8, 26.0), (66.0, 26.0)
    lines: list[tuple[int, int, tuple[Point, ...], float]] = [
        (0, 1, (east, (98.8, 48.8), (82.0, 48.8)), 2.4),
        (1, 2, ((82.0, 48.8), (66.0, 48.8)), 2.4),
        (2, 3, ((66.0, 48.8), (30.0, 48.8)), 2.4),
        (3, 4, ((30.0, 48.8), (1.2, 48.8), (1.2, 24.0)), 2.4),
        (4, 5, ((1.2, 24.0), (1.2, 1.2), (20.0, 1.2)), 2.4),
        (5, 6, ((20.0, 1.2), (38.0, 1.2), (38.0, 9.2), (52.0, 9.2), (52.0, 1.2), (66.0, 1.2)), 2.4),
        (6, 0, ((66.0, 1.2), (98.8, 1.2), east), 2.4),
        (7, 0, (four, east), 2.4),
        (7, 2, (four, (66.0, 48.8)), 2.2),
        (7, 8, (four, (66.0, 14.0)), 2.4),
        (8, 6, ((66.0, 14.0), (66.0, 1.2)), 2.4),
        (7, 3, (four, (30.0, 26.0), (30.0, 48.8)), 2.2),
        (4, 9, ((1.2, 24.0), (11.0, 24.0)), 2.2),
        (5, 10, ((20.0, 1.2), (20.0, 12.0)), 2.0),
        (8, 11, ((66.0, 14.0), (81.0, 14.0)), 2.0),
        (1, 12, ((82.0, 48.8), (82.0, 36.5)), 2.2),
    ]
    return tuple(Corridor(*line) for line in lines)


def grid(columns: int, rows: int, pitch_m: float) -> tuple[Corridor, ...]:
    """Return a regular grid of corridors 2.4 m wide."""
    corridors: list[Corridor] = []
    for row in range(rows):
        for column in range(columns):
            here, x, y = row * columns + column, column * pitch_m, row * pitch_m
            if column + 1 < columns:
                corridors.append(Corridor(here, here + 1, ((x, y), (x + pitch_m, y)), 2.4))
            if row + 1 < rows:
                corridors.append(Corridor(here, here + columns, ((x, y), (x, y + pitch_m)), 2.4))
    return tuple(corridors)


def comb(teeth: int, pitch_m: float, depth_m: float) -> tuple[Corridor, ...]:
    """Return a long loop whose lower corridor has dead ends like the teeth of a comb, one as the other."""
    length = (teeth + 1) * pitch_m
    places = [((k + 1) * pitch_m, 0.0) for k in range(teeth)]
    corridors = [Corridor(k, k + 1, (places[k], places[k + 1]), 2.4) for k in range(teeth - 1)]
    corridors += [Corridor(k, teeth + k, (place, (place[0], -depth_m)), 2.4) for k, place in enumerate(places)]
    back = (places[-1], (length, 0.0), (length, 30.0), (0.0, 30.0), (0.0, 0.0), places[0])
    corridors.append(Corridor(teeth - 1, 0, back, 2.4))
    return tuple(corridors)


def theta(length_m: float, up_m: float, down_m: float) -> tuple[Corridor, ...]:
    """Return two nodes joined by a middle corridor and two ways round it."""
    ways: list[tuple[Point, ...]] = [((0.0, 0.0), (length_m, 0.0))]
    ways += [((0.0, 0.0), (0.0, y), (length_m, y), (length_m, 0.0)) for y in (up_m, -down_m)]
    return tuple(Corridor(0, 1, line, 2.4) for line in ways)


def spoked_ring(spokes: int, radius_m: float) -> tuple[Corridor, ...]:
    """Return a ring of equal corridors with an equal dead end outwards from each of its nodes."""
    turns = [2.0 * math.pi * k / spokes for k in range(spokes)]
    inner = [(radius_m * math.cos(turn), radius_m * math.sin(turn)) for turn in turns]
    outer = [(1.6 * x, 1.6 * y) for x, y in inner]
    ring = [Corridor(k, (k + 1) % spokes, (inner[k], inner[(k + 1) % spokes]), 2.4) for k in range(spokes)]
    return (*ring, *(Corridor(k, spokes + k, (inner[k], outer[k]), 2.4) for k in range(spokes)))
