"""An occupancy grid as Nav2's map_server reads it, of beams and of the way driven.

A cell is occupied where beams ended rather than passed, free where they passed or the robot's body was, else unknown.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hslam_bringup.driven_way import PlacedStation
from hslam_bringup.errors import RunError
from hslam_types.se2 import Array

OCCUPIED, FREE, UNKNOWN = 0, 254, 205
"""Grey levels by map_server's convention, for its thresholds of 0.65 and 0.25 (and its default unknown)."""
_HIT_SHARE = 0.25
"""Share of the beams through a cell that end in it, from which it is occupied."""
_MOST_CELLS = 50_000_000
_MARGIN_M = 1.0

Cells = npt.NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """Grey levels, row 0 the highest y, as an image is stored; x, y of the lower left corner (m)."""

    grey: npt.NDArray[np.uint8]
    cell_m: float
    corner: tuple[float, float]

    def write(self, path: Path) -> Path:
        """Write ``path`` (.yaml) and a PGM of the same name beside it; return the PGM's path."""
        image = path.with_suffix(".pgm")
        height, width = self.grey.shape
        image.write_bytes(b"P5\n%d %d\n255\n" % (width, height) + self.grey.tobytes())
        path.write_text(
            f"image: {image.name}\nmode: trinary\nresolution: {self.cell_m}\n"
            f"origin: [{self.corner[0]:.3f}, {self.corner[1]:.3f}, 0.0]\n"
            "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n",
            encoding="utf-8",
        )
        return image


def occupancy(stations: Sequence[PlacedStation], cell_m: float, body_radius_m: float) -> Occupancy:
    """Return the grid of a way; raises RunError where there is none, or it takes more cells than fit."""
    if not stations:
        raise RunError("the bag shows no drive of this atlas: there is nothing to draw")
    places = np.concatenate([np.array([station.base[:2] for station in stations]), *(s.beams[:, :2] for s in stations)])
    low = np.floor((places.min(axis=0) - _MARGIN_M) / cell_m) * cell_m
    width, height = (np.ceil((places.max(axis=0) + _MARGIN_M - low) / cell_m)).astype(int).tolist()
    if width * height > _MOST_CELLS:
        raise RunError(f"{width} x {height} cells are too many; take a larger --resolution than {cell_m:g}")
    hits, passes, driven = (np.zeros((height, width), dtype=dtype) for dtype in (np.int32, np.int32, np.bool_))
    disc = _disc(body_radius_m, cell_m)
    for station in stations:
        base = np.array(station.base[:2])
        body = np.floor((base + disc - low) / cell_m).astype(np.intp)
        driven[body[:, 1], body[:, 0]] = True
        ends = np.floor((station.beams[:, :2] - low) / cell_m).astype(np.intp)
        is_hit = station.beams[:, 2] > 0.0
        through = _through(base, station.beams[station.beams[:, 3] > 0.0, :2], low, cell_m)
        np.add.at(passes, (through[:, 1], through[:, 0]), 1)
        np.add.at(hits, (ends[is_hit, 1], ends[is_hit, 0]), 1)
    grey = np.full((height, width), UNKNOWN, dtype=np.uint8)
    grey[passes > 0] = FREE
    grey[(hits > 0) & (hits >= _HIT_SHARE * (hits + passes))] = OCCUPIED
    grey[driven] = FREE
    return Occupancy(np.ascontiguousarray(grey[::-1]), cell_m, (float(low[0]), float(low[1])))


def _through(base: Array, ends: Array, low: Array, cell_m: float) -> Cells:
    """Return the cells that beams pass, each beam's once, without the cell it ends in."""
    along = ends - base
    longest = float(np.hypot(*along.T).max(initial=0.0))
    steps = np.arange(0.0, longest, 0.5 * cell_m)
    lengths = np.hypot(*along.T)
    shares = steps[None, :] / np.maximum(lengths[:, None], 1e-9)
    beam, step = np.nonzero(shares < 1.0)
    points = base + along[beam] * shares[beam, step][:, None]
    cells = np.floor((points - low) / cell_m).astype(np.intp)
    last = np.floor((ends[beam] - low) / cell_m).astype(np.intp)
    kept = (cells != last).any(axis=1)
    marked: Cells = np.unique(np.column_stack((beam, cells))[kept], axis=0)[:, 1:]
    return marked


def _disc(radius_m: float, cell_m: float) -> Array:
    steps = np.arange(-radius_m, radius_m + 0.5 * cell_m, 0.5 * cell_m)
    x, y = np.meshgrid(steps, steps)
    inside: Array = np.column_stack((x[x**2 + y**2 <= radius_m**2], y[x**2 + y**2 <= radius_m**2]))
    return inside
