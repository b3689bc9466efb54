"""Read a map_server map: a YAML beside a PGM or PNG image, as nav2_map_server understands it.

Source: nav2_map_server, map_io.cpp (modes trinary, scale and raw; colour is averaged to grey; a pixel
that is not fully opaque is unknown in mode scale).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from hslam_sim.world import WorldError
from hslam_types.se2 import SE2

Mask = npt.NDArray[np.bool_]
MODES = ("trinary", "scale", "raw")


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

    Raises WorldError (one line) on a missing or broken image, an unknown mode or values out of range.
    """
    image = _image(folder / str(content["image"]))
    resolution = float(content["resolution"])
    if not 0.0 < resolution < 10.0:
        raise WorldError(f"resolution must be metres per pixel, above 0 and below 10, not {resolution:g}")
    origin = [float(value) for value in content["origin"]]
    if len(origin) not in (2, 3) or not np.all(np.isfinite(origin)):
        raise WorldError("origin must be [x, y, yaw] in metres and radians")
    mode = str(content.get("mode", "trinary"))
    if mode not in MODES:
        raise WorldError(f"mode must be one of {', '.join(MODES)}, not '{mode}'")
    free_below = float(content.get("free_thresh", 0.25))
    if not 0.0 < free_below < 1.0:
        raise WorldError(f"free_thresh must lie between 0 and 1, not {free_below:g}")
    free = _free(image, mode, free_below, negate=bool(content.get("negate", 0)))
    return RasterMap(np.ascontiguousarray(free[::-1]), resolution, SE2(*origin))


def _image(path: Path) -> npt.NDArray[np.float64]:
    """Return an image as rows x columns x channels, scaled to 0..1."""
    if not path.is_file():
        raise WorldError(f"the image {path} does not exist")
    # imdecode, not imread: imread writes warnings of its own and cannot tell a missing file from a broken one.
    pixels = cv2.imdecode(np.frombuffer(path.read_bytes() or b"\0", dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if pixels is None:
        raise WorldError(f"the image {path} is not a readable PGM or PNG")
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    scaled: npt.NDArray[np.float64] = pixels.astype(np.float64) / float(np.iinfo(pixels.dtype).max)
    return scaled


def _free(image: npt.NDArray[np.float64], mode: str, free_below: float, *, negate: bool) -> Mask:
    """Return which pixels are free, rows as in the image."""
    colours = image.shape[2] - (1 if image.shape[2] in (2, 4) else 0)
    shade = image[:, :, :colours].mean(axis=2)
    occupied = shade if negate else 1.0 - shade
    if mode == "raw":
        # The byte itself is the occupancy in per cent; above 100 it is unknown.
        percent = np.rint(occupied * 255.0)
        raw: Mask = (percent <= 100.0) & (percent < 100.0 * free_below)
        return raw
    free: Mask = occupied < free_below
    if mode == "scale" and colours < image.shape[2]:
        free &= image[:, :, -1] >= 1.0
    return free
