"""MCAP records from bytes: the counterpart of `mcap_records`. Each function raises ValueError on malformed content."""

import struct
from collections.abc import Iterator
from typing import NamedTuple

from hslam_bags.mcap_packing import PACKINGS
from hslam_bags.mcap_records import MESSAGE

RECORD = struct.Struct("<BQ")
"""A record's opcode and length."""
CHUNK = struct.Struct("<QQQI")
"""A chunk's first and last log time (ns), its unpacked size and the checksum of that."""
OF_USERS = 0x80
"""Opcodes from here on are left to applications."""


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


class ChunkIndex(NamedTuple):
    """What the summary tells of a chunk; ``length`` is that of its whole record."""

    start_ns: int
    end_ns: int
    offset: int
    length: int
    compression: str
    packed_size: int
    size: int


class Statistics(NamedTuple):
    """What the summary counts; ``counts`` is messages by channel."""

    chunk_count: int
    counts: dict[int, int]


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
        if begin + RECORD.size > end:
            raise ValueError(f"byte {begin}: a record is cut short")
        op, length = RECORD.unpack_from(data, begin)
        if op == 0:  # zeros would be a record after the other
            raise ValueError(f"byte {begin}: no record is there")
        if begin + RECORD.size + length > end:
            raise ValueError(f"byte {begin}: a record of {length} bytes reaches past the end")
        yield op, begin, data[begin + RECORD.size : begin + RECORD.size + length]
        begin += RECORD.size + length


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
    start, end, size, crc = fields.take(CHUNK.size, "QQQI")
    compression = fields.text()
    packed = fields.number("Q")
    return ChunkHead(start, end, size, crc, compression, fields.at, fields.at + packed)


def as_chunk(content: memoryview) -> ChunkHead | None:
    """Return the head of what looks like a chunk: the lengths in it agree, its packing is known; else None."""
    try:
        head = chunk_head(content)
    except ValueError:
        return None
    return head if head.end == len(content) and head.compression in PACKINGS else None


def message(content: memoryview) -> tuple[int, int, int, bytes]:
    """Return a message's (channel, log time, publish time, data)."""
    if len(content) < MESSAGE.size - RECORD.size:
        raise ValueError("a message is shorter than its head")
    channel_id, _, log_ns, publish_ns = struct.unpack_from("<HIQQ", content)
    return channel_id, log_ns, publish_ns, bytes(content[MESSAGE.size - RECORD.size :])


def chunk_index(content: memoryview) -> ChunkIndex:
    """Parse a chunk's entry in the summary."""
    fields = Fields(content)
    start, end, offset, length = fields.take(32, "QQQQ")
    fields.bytes(fields.number("I"))
    fields.number("Q")
    compression = fields.text()
    packed_size, size = fields.take(16, "QQ")
    return ChunkIndex(start, end, offset, length, compression, packed_size, size)


def statistics(content: memoryview) -> Statistics:
    """Parse the statistics."""
    fields = Fields(content)
    chunk_count = fields.take(26, "QHIIII")[5]
    fields.take(16, "QQ")
    inner = Fields(fields.bytes(fields.number("I")))
    counts = {}
    while inner.at < len(inner.content):
        channel_id = inner.number("H")
        counts[channel_id] = inner.number("Q")
    return Statistics(chunk_count, counts)
