"""Unpacking within bounds: what would unpack to more than it says, or to more than is sane, is refused."""

import shutil
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
from backports import zstd

LARGEST = 512 << 20
"""No chunk and no message may be larger (bytes): a few kilobytes of zeros unpack to gigabytes."""

_STRIDE = 1 << 20
_ROOM_LEFT = 256 << 20
"""What unpacking a file leaves free on the disk (bytes)."""

PACKINGS = ("zstd", "lz4", "")
"""How MCAP names them; "" is unpacked."""


def unpack(compression: str, packed: memoryview | bytes, size: int) -> bytes:
    """Return what was packed if it has ``size`` bytes; raises ValueError if it has not, or cannot be unpacked."""
    if size > LARGEST:
        raise ValueError(f"says that it unpacks to {size} bytes; the most that is taken is {LARGEST}")
    data = unpack_beginning(compression, packed, size + 1)
    if len(data) != size:
        raise ValueError(f"unpacks to {'more' if len(data) > size else len(data)} bytes where {size} should be")
    return data


def unpack_beginning(compression: str, packed: memoryview | bytes, most: int) -> bytes:
    """Return at most ``most`` bytes of what was packed, fewer if its end is missing; raises ValueError if damaged."""
    try:
        if compression == "zstd":
            return zstd.ZstdDecompressor().decompress(packed, most)
        if compression == "lz4":
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, most))
    except (zstd.ZstdError, RuntimeError, OverflowError, EOFError, MemoryError) as error:
        raise ValueError(f"cannot be unpacked: {error}") from error
    if compression:
        raise ValueError(f"is packed by '{compression}', which is unknown")
    return bytes(packed[:most])


def unpack_message(packed: bytes) -> bytes:
    """Return a message that zstd packed alone; raises ValueError as `unpack` does."""
    try:
        size = zstd.get_frame_info(packed).decompressed_size
    except zstd.ZstdError as error:
        raise ValueError(f"cannot be unpacked: {error}") from error
    if size:  # else the packer did not tell
        return unpack("zstd", packed, size)
    data = unpack_beginning("zstd", packed, LARGEST + 1)
    if len(data) > LARGEST:
        raise ValueError(f"unpacks to more than the {LARGEST} bytes that are taken")
    return data


def unpack_file(packed: Path, target: Path) -> None:
    """Unpack a file that zstd packed as a whole; raises ValueError or OSError if that cannot be."""
    room = shutil.disk_usage(target.parent).free - _ROOM_LEFT
    try:
        with zstd.open(packed, "rb") as stream, target.open("wb") as sink:
            while (piece := stream.read(_STRIDE)) and sink.tell() < room:
                sink.write(piece)
    except (EOFError, zstd.ZstdError) as error:
        raise ValueError(f"cannot be unpacked: {error}") from error
    if piece:
        target.unlink()
        raise ValueError(f"unpacks to more than the {max(room, 0)} bytes that there is room for in {target.parent}")
