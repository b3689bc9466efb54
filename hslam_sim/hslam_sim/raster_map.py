"""Read a map_server map: a YAML beside a PGM or PNG image, as nav2_map_server understands it.

Source: nav2_map_server of Jazzy, map_io.cpp.  Where this differs (the package's README lists it), it refuses what that
lets through.
"""

import functools
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from hslam_sim.floor_plan import KEYS_OF_ANY_WORLD
from hslam_sim.map_image import Mask, read_image
from hslam_sim.section import Section, numbers, shown
from hslam_sim.world import WorldError
from hslam_types.se2 import SE2

MODES = ("trinary", "scale", "raw")
MAP_KEYS = ("image", "mode", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
UNKNOWN_GREY = 205
"""How map_saver writes a pixel it knows nothing of."""
RESOLUTIONS_M = (0.001, 10.0)
TRUTHS = dict.fromkeys(("true", "yes", "on", "y"), True) | dict.fromkeys(("false", "no", "off", "n"), False)


@dataclass(frozen=True, eq=False)
class RasterMap:
    """Which pixels are known to be free; everything else, unknown too, counts as obstacle."""

    free: Mask
    """rows x columns; row 0 is the lowest y (the image's last row)."""
    resolution_m: float
    """Side of a pixel."""
    origin_in_map: SE2
    """Pose in map of the lower left corner of the lower left pixel."""


def read(folder: Path, content: Mapping[str, Any]) -> RasterMap:
    """Return the map a map_server YAML's ``content`` describes; its image is looked for from ``folder``.

    Raises WorldError (one line) on a missing or broken image, on a value that is missing, unknown or out of range.
    """
    given = Section(content, "", (*MAP_KEYS, *KEYS_OF_ANY_WORLD))
    mode = given.text("mode", "trinary").lower()
    if mode not in MODES:
        raise WorldError(f"mode must be one of {', '.join(MODES)}, not {shown(mode)}")
    resolution = given.number("resolution", *RESOLUTIONS_M)
    origin = numbers(given.value("origin"), "origin", "[x, y, yaw] in metres and radians")
    occupied_from, free_to = (given.number(key, 0.0, 1.0) for key in ("occupied_thresh", "free_thresh"))
    if free_to >= occupied_from:
        raise WorldError(f"free_thresh must be below occupied_thresh, not {free_to:g} with {occupied_from:g}")
    free_of_grey = free_greys(mode, free_to, negate=_negate(given.value("negate")))
    path = folder / given.text("image")
    image = read_image(path)
    if mode != "raw" and free_of_grey[UNKNOWN_GREY] and np.any(image.grey == UNKNOWN_GREY):
        _warn(f"{path}: free_thresh {free_to:g} makes grey {UNKNOWN_GREY} free, map_saver's sign for unknown")
    free = cv2.LUT(image.grey, free_of_grey.view(np.uint8)).view(np.bool_)
    if mode != "raw" and image.opaque is not None:
        free &= image.opaque
    return RasterMap(np.ascontiguousarray(free[::-1]), resolution, SE2(*origin))


def free_greys(mode: str, free_to: float, *, negate: bool) -> Mask:
    """Return which of the 256 greys are free, where opaque.

    Raw greys are the occupancy in per cent and unknown above 100; others become an occupancy of 0 to 1, by the single
    precision of map_server.
    """
    greys = np.arange(256, dtype=np.float32)
    if mode == "raw":
        free: Mask = (greys <= 100.0) & (greys / 100.0 <= free_to)
    else:
        shade = greys / np.float32(255.0)
        free = (shade if negate else np.float32(1.0) - shade) <= np.float32(free_to)
    return free


def _negate(value: Any) -> bool:
    """Return whether white is occupied: a whole number, or a truth in YAML's words, as text too."""
    text = str(value).lower()
    if text in TRUTHS:
        return TRUTHS[text]
    try:
        return int(text) != 0
    except ValueError:
        raise WorldError(f"negate must be 0 or 1, true or false, not {shown(value)}") from None


@functools.cache
def _warn(problem: str) -> None:
    """Tell the user once, however often a run reads its world."""
    logging.getLogger(__name__).warning(problem)
