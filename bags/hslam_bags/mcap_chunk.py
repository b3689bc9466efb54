"""The records of a chunk, by whichever of its head and the file's index its checksum says is right."""

import contextlib
import zlib
from collections.abc import Iterator

from hslam_bags import mcap_parsing as parse
from hslam_bags.mcap_packing import LARGEST, PACKINGS, unpack, unpack_beginning


def unpack_chunk(head: parse.ChunkHead, content: memoryview) -> bytes:
    """Return a chunk's records, their size and checksum verified; ValueError if they are damaged."""
    data = unpack(head.compression, content[head.begin : head.end], head.size)
    if head.crc and zlib.crc32(data) != head.crc:
        raise ValueError("differs from its checksum")
    return data


def is_verified(content: memoryview) -> bool:
    """Whether the content of a record is that of a chunk with a checksum, which it has."""
    try:
        head = parse.chunk_head(content)
        unpack_chunk(head, content)
    except ValueError:
        return False
    return bool(head.crc)


def read_chunk(content: memoryview, entry: parse.ChunkIndex | None) -> tuple[bytes, str]:
    """Return a chunk's records and what is wrong with its head, "" if nothing is; ValueError if they are damaged.

    ``entry`` is what the index tells of it, if the file has one.
    """
    own = parse.as_chunk(content)
    problem = "its head is damaged"
    if own is not None and (entry is None or _agree(own, entry)):
        try:
            return unpack_chunk(own, content), ""
        except ValueError as error:
            problem = str(error)
    crc = parse.CHUNK.unpack_from(content)[3] if len(content) >= parse.CHUNK.size else 0
    for packing, begin, end in _places(content, entry) if crc else ():
        try:
            data = unpack_beginning(packing, content[begin:end], LARGEST)
        except ValueError:
            continue
        if zlib.crc32(data) == crc:
            return data, f"{problem}; what it holds is whole"
    raise ValueError(problem)


def read_cut_chunk(content: memoryview) -> bytes:
    """Return the whole records at the beginning of a chunk whose end is missing; nothing can verify them."""
    try:
        head = parse.chunk_head(content)
        data = unpack_beginning(head.compression, content[head.begin :], min(head.size, LARGEST))
    except ValueError:
        return b""
    whole = 0
    try:
        for _, offset, inner in parse.records(memoryview(data), 0, len(data)):
            whole = offset + parse.RECORD.size + len(inner)
    except ValueError:
        pass
    return data[:whole]


def _agree(head: parse.ChunkHead, entry: parse.ChunkIndex) -> bool:
    """Whether a chunk's head and its entry in the index tell the same of it."""
    return (head.start_ns, head.end_ns, head.compression, head.size, head.end - head.begin) == (
        entry.start_ns,
        entry.end_ns,
        entry.compression,
        entry.size,
        entry.packed_size,
    )


def _places(content: memoryview, entry: parse.ChunkIndex | None) -> Iterator[tuple[str, int, int]]:
    """Yield how and where in a chunk its records may be packed: by the index, by its own head, by any packing."""
    if entry is not None:
        yield entry.compression, len(content) - entry.packed_size, len(content)
    for packing in PACKINGS:
        yield packing, parse.CHUNK.size + 4 + len(packing) + 8, len(content)
    with contextlib.suppress(ValueError):
        head = parse.chunk_head(content)
        yield head.compression, head.begin, head.end
