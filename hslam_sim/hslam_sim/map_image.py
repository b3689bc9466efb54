"""The image of a map_server map (PGM or PNG) as 8-bit grey and opacity, in a few bytes a pixel.

As nav2_map_server has ImageMagick bring it: other depths are scaled so that the largest value is 255, colour is weighed
by Rec. 709.  OpenCV takes a PGM's values as they are, whatever its header says of the largest, so PGM is read here.
"""

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from hslam_sim.world import WorldError

Grey = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]

MOST_PIXELS = 100_000_000
"""500 m x 500 m at 0.05 m a pixel; only a mistaken header claims more."""
BAND = 1_000_000
"""Values that are worked on at a time, so that no step needs the whole image in wide numbers."""
LUMA_BGR = np.array([0.072186, 0.715158, 0.212656])
"""Rec. 709, in OpenCV's order of channels."""
LARGEST_GREY = 65_535
PNG = b"\x89PNG\r\n\x1a\n"


class MapImage(NamedTuple):
    """An image; its first row is the top."""

    grey: Grey
    """Rows x columns; 0 black, 255 white."""
    opaque: Mask | None
    """Where alpha is full; None if there is no alpha."""


def read_image(path: Path) -> MapImage:
    """Return the PGM (P2, P5) or PNG image in a file.

    Raises WorldError where there is none, where it is damaged, and where it claims more than `MOST_PIXELS`.
    """
    try:
        if not path.is_file():
            raise WorldError(f"the image {path} does not exist")
        with path.open("rb") as file:
            magic = file.read(2)
            if magic in (b"P2", b"P5"):
                return MapImage(_pgm(file, plain=magic == b"P2"), None)
            file.seek(0)
            return _png(file)
    except OSError as error:
        raise WorldError(f"the image {path} cannot be read ({error.strerror})") from None
    except _DamagedError as error:
        raise WorldError(f"the image {path} is not a readable PGM or PNG: {error}") from None


class _DamagedError(Exception):
    """What is wrong with an image; `read_image` adds which."""


def _pixels(columns: int, rows: int) -> int:
    """Return how many pixels a header claims, if that can be meant."""
    if columns < 1 or rows < 1:
        raise _DamagedError("it has no pixels")
    if columns * rows > MOST_PIXELS:
        raise _DamagedError(f"it claims {columns} x {rows} pixels, and at most {MOST_PIXELS} are read")
    return columns * rows


def _pgm(file: BinaryIO, *, plain: bool) -> Grey:
    """Return the pixels of a PGM (netpbm's pgm(5)) whose magic number has been read."""
    try:
        columns, rows, largest = (int(_word(file)) for _ in range(3))
    except ValueError:
        raise _DamagedError("its header is no PGM's") from None
    count = _pixels(columns, rows)
    if not 1 <= largest <= LARGEST_GREY:
        raise _DamagedError(f"its largest value is {largest}, not 1 to {LARGEST_GREY}")
    scaled = np.rint(np.arange(largest + 1) * (255.0 / largest)).astype(np.uint8)
    grey = np.empty(count, dtype=np.uint8)
    filled = 0
    for values in _plain_values(file) if plain else _raw_values(file, count, largest):
        band = values[: count - filled]
        if len(band) and not 0 <= band.min() <= band.max() <= largest:
            raise _DamagedError(f"it holds a value that is not 0 to {largest}")
        grey[filled : filled + len(band)] = scaled[band]
        filled += len(band)
        if filled == count:
            return grey.reshape(rows, columns)
    raise _DamagedError(f"it ends after {filled} of {count} pixels")


def _word(file: BinaryIO) -> bytes:
    """Return the next word of a PGM's header, with the one white space behind it consumed."""
    word = b""
    while byte := file.read(1):
        if byte == b"#":
            file.readline()
        elif not byte.isspace():
            word += byte
        elif word:
            break
    return word[:20]


def _raw_values(file: BinaryIO, count: int, largest: int) -> Iterator[npt.NDArray[np.integer]]:
    """Yield a P5's values by bands; two bytes each, the high one first, where one does not hold the largest."""
    kind = np.dtype(np.uint8 if largest < 256 else ">u2")
    for begin in range(0, count, BAND):
        data = file.read(min(BAND, count - begin) * kind.itemsize)
        yield np.frombuffer(data[: len(data) // kind.itemsize * kind.itemsize], dtype=kind)


def _plain_values(file: BinaryIO) -> Iterator[npt.NDArray[np.integer]]:
    """Yield a P2's values by bands; they are decimal numbers between white space."""
    while text := file.read(BAND):
        while not text[-1:].isspace() and (byte := file.read(1)):
            text += byte
            if len(text) > BAND + 20:
                raise _DamagedError("it holds what is no number")
        try:
            yield np.array([int(word) for word in text.split()])
        except ValueError:
            raise _DamagedError("it holds what is no number") from None


def _png(file: BinaryIO) -> MapImage:
    """Return the pixels of a PNG."""
    head = file.read(24)
    if len(head) < 24 or not head.startswith(PNG):
        raise _DamagedError("it begins like neither")
    columns, rows = struct.unpack(">II", head[16:24])
    _pixels(columns, rows)
    data = head + file.read()
    _check_chunks(data)
    pixels = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if pixels is None or pixels.shape[:2] != (rows, columns):
        raise _DamagedError("its data are damaged")
    if pixels.dtype == np.uint8 and pixels.ndim == 2:
        return MapImage(pixels, None)
    largest = float(np.iinfo(pixels.dtype).max)
    pixels = pixels.reshape(rows, columns, -1)
    grey = np.empty((rows, columns), dtype=np.uint8)
    opaque = np.empty((rows, columns), dtype=np.bool_) if pixels.shape[2] == 4 else None
    for begin in range(0, rows, max(1, BAND // columns)):
        band = slice(begin, begin + max(1, BAND // columns))
        shade = pixels[band, :, 0] if pixels.shape[2] == 1 else pixels[band, :, :3] @ LUMA_BGR
        grey[band] = np.rint(shade * (255.0 / largest))
        if opaque is not None:
            opaque[band] = pixels[band, :, 3] == largest
    return MapImage(grey, opaque)


def _check_chunks(data: bytes) -> None:
    """Refuse a PNG whose check sums are wrong, of which OpenCV makes half an image and messages of its own."""
    at, kind = len(PNG), b""
    while kind != b"IEND":
        if at + 12 > len(data):
            raise _DamagedError("its data break off")
        (length,) = struct.unpack_from(">I", data, at)
        kind = data[at + 4 : at + 8]
        (check,) = struct.unpack(">I", data[at + 8 + length : at + 12 + length].ljust(4, b"\0"))
        if zlib.crc32(memoryview(data)[at + 4 : at + 8 + length]) != check:
            raise _DamagedError("its data are damaged")
        at += 12 + length
