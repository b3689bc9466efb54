"""Draws floors that nothing was ever tuned on: by a seed, as map_server maps that every command reads.

hslam-env python bench/drawn_floors.py FOLDER --seeds 1-2
hslam-env python bench/gvg_level.py FOLDER/*.yaml --sensor scan
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

PIXEL_M = 0.05
Free = npt.NDArray[np.bool_]
"""Where a floor is free, by row (y upwards) and column (x)."""
Floor = tuple[Free, tuple[float, float]]
"""The free pixels, and where to start (m)."""


def pillared_hall(rng: np.random.Generator) -> Floor:
    """Return a hall of 40 by 30 m with pillars about six metres apart."""
    free = _walled(40.0, 30.0)
    for x in np.arange(5.0, 38.0, 6.0):
        for y in np.arange(4.5, 28.0, 6.0):
            side = rng.uniform(0.4, 1.0)
            px, py = np.array([x, y]) + rng.uniform(-0.8, 0.8, 2)
            _set(free, px - side / 2, py - side / 2, px + side / 2, py + side / 2, False)
    return free, (2.0, 2.0)


def bare_hall(rng: np.random.Generator) -> Floor:
    """Return an empty hall of 40 by 30 m, wider than a small scanner reaches, with a corridor off each side."""
    free = _solid(64.0, 54.0)
    _set(free, 12.0, 12.0, 52.0, 42.0, True)
    for x in (rng.uniform(16.0, 30.0), rng.uniform(34.0, 48.0)):
        _set(free, x - 1.1, 2.0, x + 1.1, 12.0, True)
        _set(free, x - 1.1, 42.0, x + 1.1, 52.0, True)
    y = rng.uniform(17.0, 37.0)
    _set(free, 2.0, y - 1.1, 12.0, y + 1.1, True)
    y = rng.uniform(17.0, 37.0)
    _set(free, 52.0, y - 1.1, 62.0, y + 1.1, True)
    return free, (62.0 - 2.0, float(y))


def offices(rng: np.random.Generator) -> Floor:
    """Return thirty rooms of 3 by 4 m with doors of 0.8 m, along both sides of two corridors joined at their ends."""
    free = _solid(31.0, 30.0)
    walls_m, door_m, corridor_m = 0.15, 0.8, 1.8
    for y in (5.2, 19.5):
        _set(free, 1.0, y, 30.0, y + corridor_m, True)
    for x in (1.0, 30.0 - corridor_m):
        _set(free, x, 5.2, x + corridor_m, 19.5 + corridor_m, True)
    sides = ((5.2, -1.0, 1.0), (5.2 + corridor_m, 1.0, 3.2), (19.5, -1.0, 3.2), (19.5 + corridor_m, 1.0, 1.0))
    for count, (y, side, first) in zip((8, 7, 7, 8), sides, strict=True):
        for k in range(count):
            x = first + k * (3.0 + walls_m) + (0.5 if count == 8 else 0.0)
            near, far = sorted((y + side * walls_m, y + side * (walls_m + 4.0)))
            _set(free, x, near, x + 3.0, far, True)
            door = x + rng.uniform(0.2, 3.0 - door_m - 0.2)
            _set(free, door, min(y, y + side * walls_m), door + door_m, max(y, y + side * walls_m), True)
    return free, (2.0, 6.1)


def cave(rng: np.random.Generator) -> Floor:
    """Return an irregular floor: smoothed noise above a level, its largest part."""
    height, width = round(30.0 / PIXEL_M), round(40.0 / PIXEL_M)
    coarse = rng.standard_normal((height, width))
    field = cv2.GaussianBlur(coarse, (0, 0), 1.3 / PIXEL_M)
    free = field > np.quantile(field, 0.42)
    free[:20], free[-20:], free[:, :20], free[:, -20:] = False, False, False, False
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    free = labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    room = cv2.distanceTransform(free.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    row, column = np.unravel_index(int(np.argmax(np.minimum(room, 1.0 / PIXEL_M))), room.shape)
    return free, (float(column + 0.5) * PIXEL_M, float(row + 0.5) * PIXEL_M)


def ring_of_alcoves(rng: np.random.Generator) -> Floor:
    """Return a round corridor of 2.2 m with alcoves of several depths on its outer side."""
    side_m, radius_m, half_m = 40.0, 13.0, 1.1
    rows, columns = np.mgrid[0 : round(side_m / PIXEL_M), 0 : round(side_m / PIXEL_M)]
    x, y = (columns + 0.5) * PIXEL_M - side_m / 2, (rows + 0.5) * PIXEL_M - side_m / 2
    away = np.hypot(x, y)
    free = np.abs(away - radius_m) < half_m
    for k in range(10):
        angle = k * np.pi / 5 + rng.uniform(-0.1, 0.1)
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
        depth, width = rng.uniform(0.5, 4.5), rng.uniform(0.9, 2.0)
        free |= (np.abs(across) < width / 2) & (along > radius_m) & (along < radius_m + half_m + depth)
    return free, (side_m / 2 + radius_m, side_m / 2)


FLOORS: dict[str, Callable[[np.random.Generator], Floor]] = {
    "pillared_hall": pillared_hall,
    "bare_hall": bare_hall,
    "offices": offices,
    "cave": cave,
    "ring_of_alcoves": ring_of_alcoves,
}


def draw(folder: Path, name: str, seed: int) -> Path:
    """Write one floor as a map_server map; return its YAML file."""
    free, (x, y) = FLOORS[name](np.random.default_rng(seed))
    stem = f"{name}_{seed}"
    cv2.imwrite(str(folder / f"{stem}.png"), np.where(free[::-1], 254, 0).astype(np.uint8))
    file = folder / f"{stem}.yaml"
    file.write_text(
        f"image: {stem}.png\nresolution: {PIXEL_M}\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n"
        f"free_thresh: 0.2\nstart: {{x: {x:.3f}, y: {y:.3f}, heading_deg: 0.0}}\n",
        encoding="utf-8",
    )
    return file


def _solid(width_m: float, height_m: float) -> Free:
    return np.zeros((round(height_m / PIXEL_M), round(width_m / PIXEL_M)), bool)


def _walled(width_m: float, height_m: float) -> Free:
    free = ~_solid(width_m, height_m)
    free[:4], free[-4:], free[:, :4], free[:, -4:] = False, False, False, False
    return free


def _set(free: Free, left: float, low: float, right: float, high: float, value: bool) -> None:
    """Set a rectangle (m)."""
    low_px, high_px, left_px, right_px = (round(edge / PIXEL_M) for edge in (low, high, left, right))
    free[low_px:high_px, left_px:right_px] = value


def main() -> None:
    """Parse the command line and write the maps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", default="1", help="one seed or a range, such as 1-3")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    first, _, last = options.seeds.partition("-")
    for seed in range(int(first), int(last or first) + 1):
        for name in FLOORS:
            draw(options.folder, name, seed)


if __name__ == "__main__":
    main()
