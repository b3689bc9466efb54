"""From the pixels of a map to the one polygon a robot of a given size can use.

Three steps (each keeps the clearance of what stays exact):

1. reach: of the pixels with clearance >= rc = robot radius + 0.06 m keep the component of the start, and
   grow it back by rc.  This opening drops scan rays and cracks.
2. islands: holes whose bounding box has a diagonal under 0.30 m are filled; both steps are repeated.
3. contours: the outlines between pixels, each smoothed by a moving average of five points and simplified
   within half a pixel.

Without a given start the component is the largest that does not reach the image's edge: what lies around
a drawn building is free too, and often larger than the building.
"""

import itertools
from dataclasses import dataclass
from typing import cast

import contourpy
import cv2
import numpy as np
import numpy.typing as npt
import shapely

from hslam_sim.map_image import Mask
from hslam_sim.raster_map import RasterMap
from hslam_sim.world import WorldError
from hslam_types.se2 import SE2, Array

ROBOT_RADIUS_M = 0.19
"""Body of the Nomadic Scout."""
REACH_MARGIN_M = 0.06
"""Beyond the body's radius, what a robot keeps off a wall at least."""
OUTSIDE_SHARE = 0.1
"""Free space on more than this of the image's border is the outside of a building; a ray out of a window is not."""
ISLAND_DIAGONAL_M = 0.30
ROUNDS = 3
COMFORTABLE_CLEARANCE_M = 1.2
"""An automatic start needs no more room than a corridor gives; the most interior point would be a hall's middle."""


@dataclass(frozen=True)
class RasterFloor:
    """The usable free space of a map and where to start in it, both in map."""

    free_space: shapely.Polygon
    start: SE2


def clean(source: RasterMap, start: SE2 | None, reach_m: float = ROBOT_RADIUS_M + REACH_MARGIN_M) -> RasterFloor:
    """Return the floor reachable from ``start`` (map frame), or from a start chosen by the rule above.

    Raises WorldError if the start is not free or the map has no room for the robot.
    """
    # The frame of obstacle around the image lets a map end in free space.
    free = np.pad(source.free, 1)
    reach = reach_m / source.resolution_m
    seed = _start_pixel(source, start, free, reach)
    for _ in range(ROUNDS):
        opened = _opening(free, seed, reach)
        free, filled = _without_islands(opened, ISLAND_DIAGONAL_M / source.resolution_m)
        if not filled:
            break
    polygon = _polygon(free, seed)
    pose = start if start is not None else _map_pose(source, seed)
    return RasterFloor(_in_map(source, polygon), pose)


def clearance_px(free: Mask) -> npt.NDArray[np.float32]:
    """Return every pixel's distance (pixels) from its centre to the nearest obstacle pixel's centre."""
    distance: npt.NDArray[np.float32] = np.asarray(
        cv2.distanceTransform(free.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE), dtype=np.float32
    )
    return distance


def _start_pixel(source: RasterMap, start: SE2 | None, free: Mask, reach: float) -> tuple[int, int]:
    """Return the (row, column) in the padded mask of the given or chosen start."""
    clearance = clearance_px(free)
    if start is None:
        return _chosen_start(free, clearance, reach, COMFORTABLE_CLEARANCE_M / source.resolution_m)
    inverse = source.origin_in_map.inverse()
    x, y = inverse.apply(start.x, start.y)
    column, row = int(np.floor(x / source.resolution_m)) + 1, int(np.floor(y / source.resolution_m)) + 1
    rows, columns = free.shape
    if not (0 <= row < rows and 0 <= column < columns and clearance[row, column] >= reach):
        needed = reach * source.resolution_m
        raise WorldError(f"the start ({start.x:g}, {start.y:g}) has less than {needed:.2f} m to the next obstacle")
    return row, column


def _chosen_start(free: Mask, clearance: npt.NDArray[np.float32], reach: float, comfortable: float) -> tuple[int, int]:
    """Return the roomiest pixel (up to ``comfortable``) nearest to the middle of the largest component inside."""
    labels = _labels(clearance >= reach)
    areas = np.bincount(labels.ravel())
    areas[0] = 0
    if areas.max() == 0:
        raise WorldError("the map has no room for the robot")
    regions = _labels(free)
    on_border = np.bincount(regions[_border(free)], minlength=int(regions.max()) + 1)
    around = np.flatnonzero(on_border > OUTSIDE_SHARE * np.count_nonzero(_border(np.ones_like(free))))
    at_edge = np.isin(regions, around) & free
    reaches_edge = np.zeros(len(areas), dtype=bool)
    reaches_edge[labels[at_edge]] = True
    enclosed = np.where(reaches_edge, 0, areas)
    best = int(np.argmax(enclosed if enclosed.max() * 50 >= areas.max() else areas))
    rows, columns = np.nonzero(labels == best)
    room = np.minimum(clearance[rows, columns], comfortable)
    off_middle = np.hypot(rows - rows.mean(), columns - columns.mean())
    roomiest = room >= room.max() - 1e-3
    chosen = int(np.argmin(np.where(roomiest, off_middle, np.inf)))
    return int(rows[chosen]), int(columns[chosen])


def _border(free: Mask) -> Mask:
    """Return the mask of the image's outermost pixels, inside the padding."""
    border = np.zeros_like(free)
    border[1, 1:-1] = border[-2, 1:-1] = border[1:-1, 1] = border[1:-1, -2] = True
    return border


def _labels(mask: Mask) -> npt.NDArray[np.int32]:
    """Return 4-connected component numbers, 0 outside the mask."""
    return np.asarray(cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)[1], dtype=np.int32)


def _opening(free: Mask, seed: tuple[int, int], reach: float) -> Mask:
    """Return what a disc of ``reach`` pixels sweeps from ``seed``."""
    labels = _labels(clearance_px(free) >= reach)
    centre = labels == labels[seed]
    swept: Mask = clearance_px(~centre) < reach
    return swept & free


def _without_islands(free: Mask, diagonal: float) -> tuple[Mask, bool]:
    """Return ``free`` with its small holes filled, and whether there were any."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats((~free).astype(np.uint8), connectivity=8)
    small = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) < diagonal
    small[0] = False
    filled: Mask = free | small[labels]
    return filled, bool(small.any())


def _polygon(free: Mask, seed: tuple[int, int]) -> shapely.Polygon:
    """Return the outline (pixels; pixel centres at whole numbers) of the free region about ``seed``."""
    generator = contourpy.contour_generator(z=free.astype(np.float64), fill_type=contourpy.FillType.OuterOffset)
    # The library's hint covers every fill type; this one gives points and ring offsets of each polygon.
    polygons, offsets = cast("tuple[list[Array], list[Array]]", generator.filled(0.5, np.inf))
    here = shapely.Point(seed[1], seed[0])
    for points, starts in zip(polygons, offsets, strict=True):
        rings = [np.asarray(points[a:b]) for a, b in itertools.pairwise(starts.tolist())]
        if not shapely.Polygon(rings[0]).contains(here):
            continue
        smooth = [_smoothed(ring[:-1]) for ring in rings]
        shape = shapely.Polygon(smooth[0], smooth[1:]).simplify(0.5)
        # Smoothing can make two outlines touch across a wall of one pixel.
        parts = shapely.get_parts(shapely.make_valid(shape))
        holding = [part for part in parts if isinstance(part, shapely.Polygon) and part.contains(here)]
        if holding:
            return holding[0]
    raise WorldError("the map has no room for the robot")


def _smoothed(ring: Array) -> Array:
    """Return a closed ring (n x 2, last point not repeated) under a moving average of five points."""
    if len(ring) < 10:
        return ring
    average: Array = sum((np.roll(ring, shift, axis=0) for shift in (-2, -1, 1, 2)), ring) / 5.0
    return average


def _map_pose(source: RasterMap, pixel: tuple[int, int]) -> SE2:
    """Return the pose in map of a pixel's centre, facing along the image's columns."""
    row, column = pixel
    return source.origin_in_map @ SE2((column - 0.5) * source.resolution_m, (row - 0.5) * source.resolution_m)


def _in_map(source: RasterMap, polygon: shapely.Polygon) -> shapely.Polygon:
    """Return a polygon of padded pixel coordinates in map."""

    def moved(points: Array) -> Array:
        return source.origin_in_map.apply_all((points - 0.5) * source.resolution_m)

    return shapely.transform(polygon, moved)
