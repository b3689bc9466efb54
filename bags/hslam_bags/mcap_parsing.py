"""MCAP records from bytes: the counterpart of `mcap_records`. Each function raises ValueError on malformed content."""

import struct
import zlib
from collections.abc import Iterator
from typing import NamedTuple

import lz4.frame  # type: ignore[import-untyped]
from backports import zstd

from hslam_bags.mcap_records import MESSAGE, Op

_RECORD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQI")


class SchemaRecord(NamedTuple):
    """A type's definition."""

    id: int
    name: str
    encoding: str
    text: str


class ChannelRecord(NamedTuple):
    """A topic."""

    id: int
    schema_id: int
    topic: str
    encoding: str
    metadata: dict[str, str]


class ChunkHead(NamedTuple):
    """A chunk up to its packed records, which are bytes ``begin`` to ``end`` of the content."""

    start_ns: int
    end_ns: int
    size: int
    crc: int
    compression: str
    begin: int
    end: int


class Fields:
    """Reads one field after the other."""

    def __init__(self, content: memoryview) -> None:
        """Start at the first byte."""
        self.content = content
        self.at = 0

    def number(self, kind: str) -> int:
        """Return the next little-endian number of struct's ``kind``."""
        (value,) = self.take(struct.calcsize("<" + kind), kind)
        return int(value)

    def take(self, size: int, kind: str) -> tuple[int, ...]:
        """Unpack the next ``size`` bytes."""
        return struct.unpack("<" + kind, self.bytes(size))

    def bytes(self, size: int) -> memoryview:
        """Return the next ``size`` bytes."""
        if self.at + size > len(self.content):
            raise ValueError("a field reaches past the end of its record")
        self.at += size
        return self.content[self.at - size : self.at]

    def text(self) -> str:
        """Return the next string."""
        return str(self.bytes(self.number("I")), "utf-8")

    def pairs(self) -> dict[str, str]:
        """Return the next map of strings."""
        inner = Fields(self.bytes(self.number("I")))
        values = {}
        while inner.at < len(inner.content):
            key = inner.text()
            values[key] = inner.text()
        return values


def records(data: memoryview, begin: int, end: int) -> Iterator[tuple[int, int, memoryview]]:
    """Yield (opcode, offset, content) of each record from ``begin`` to ``end``; ValueError where one is cut short."""
    while begin < end:
        if begin + _RECORD.size > end:
            raise ValueError(f"byte {begin}: a record is cut short")
        op, length = _RECORD.unpack_from(data, begin)
        if begin + _RECORD.size + length > end:
            raise ValueError(f"byte {begin}: a record of {length} bytes reaches past the end")
        yield op, begin, data[begin + _RECORD.size : begin + _RECORD.size + length]
        begin += _RECORD.size + length


def schema(content: memoryview) -> SchemaRecord:
    """Parse a schema."""
    fields = Fields(content)
    return SchemaRecord(fields.number("H"), fields.text(), fields.text(), fields.text())


def channel(content: memoryview) -> ChannelRecord:
    """Parse a channel."""
    fields = Fields(content)
    return ChannelRecord(fields.number("H"), fields.number("H"), fields.text(), fields.text(), fields.pairs())


def chunk_head(content: memoryview) -> ChunkHead:
    """Parse a chunk up to its packed records; of one cut short, ``end`` reaches past the content."""
    fields = Fields(content)
    start, end, size, crc = fields.take(_CHUNK.size, "QQQI")
    compression = fields.text()
    packed = fields.number("Q")
    return ChunkHead(start, end, size, crc, compression, fields.at, fields.at + packed)


def unpack_chunk(head: ChunkHead, content: memoryview) -> bytes:
    """Return a chunk's records, their size and checksum verified."""
    packed = content[head.begin : head.end]
    try:
        if head.compression == "zstd":
            data = zstd.ZstdDecompressor().decompress(packed, head.size + 1)
        elif head.compression == "lz4":
            data = lz4.frame.decompress(packed)
        elif head.compression == "":
            data = bytes(packed)
        else:
            raise ValueError(f"is packed by '{head.compression}', which is unknown")
    except (zstd.ZstdError, RuntimeError, OverflowError) as error:
        raise ValueError(f"cannot be unpacked: {error}") from error
    if len(data) != head.size:
        raise ValueError(f"has {len(data)} bytes where {head.size} should be")
    if head.crc and zlib.crc32(data) != head.crc:
        raise ValueError("differs from its checksum")
    return data


def unpack_cut_chunk(head: ChunkHead, content: memoryview) -> bytes:
    """Return the whole records at the beginning of a chunk whose end is missing; nothing can verify them."""
    packed = bytes(content[head.begin :])
    data = packed
    try:
        if head.compression == "zstd":
            data = zstd.ZstdDecompressor().decompress(packed)
        elif head.compression == "lz4":
            data = lz4.frame.LZ4FrameDecompressor().decompress(packed)
    except (zstd.ZstdError, RuntimeError):
        return b""
    whole = 0
    try:
        for _, offset, inner in records(memoryview(data), 0, len(data)):
            whole = offset + _RECORD.size + len(inner)
    except ValueError:
        pass
    return data[:whole]


def message(content: memoryview) -> tuple[int, int, int, bytes]:
    """Return a message's (channel, log time, publish time, data)."""
    if len(content) < MESSAGE.size - _RECORD.size:
        raise ValueError("a message is shorter than its head")
    channel_id, _, log_ns, publish_ns = struct.unpack_from("<HIQQ", content)
    return channel_id, log_ns, publish_ns, bytes(content[MESSAGE.size - _RECORD.size :])


def chunk_index(content: memoryview) -> tuple[int, int, int]:
    """Return (first log time, last log time, offset of the chunk)."""
    start, end, offset = Fields(content).take(24, "QQQ")
    return start, end, offset


def statistics(content: memoryview) -> tuple[tuple[int, int], dict[int, int]]:
    """Return ((first, last log time), messages by channel)."""
    fields = Fields(content)
    fields.bytes(8 + 2 + 4 + 4 + 4 + 4)
    span = fields.number("Q"), fields.number("Q")
    inner = Fields(fields.bytes(fields.number("I")))
    counts = {}
    while inner.at < len(inner.content):
        channel_id = inner.number("H")
        counts[channel_id] = inner.number("Q")
    return span, counts


def is_record(op: int) -> bool:
    """Return whether an opcode is one of the format's, or of the range left to applications."""
    return Op.HEADER <= op <= Op.DATA_END or op >= 0x80
