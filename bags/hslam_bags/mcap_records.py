"""MCAP records as bytes (https://mcap.dev/spec, version 0): each is an opcode, a length and its content."""

import struct
from collections.abc import Mapping, Sequence
from enum import IntEnum

MAGIC = b"\x89MCAP0\r\n"

MESSAGE = struct.Struct("<BQHIQQ")
"""A message record up to its data: opcode, length, channel, sequence, log time, publish time (both ns)."""

_RECORD = struct.Struct("<BQ")
_LENGTH = struct.Struct("<I")


class Op(IntEnum):
    """What a record is."""

    HEADER = 0x01
    FOOTER = 0x02
    SCHEMA = 0x03
    CHANNEL = 0x04
    MESSAGE = 0x05
    CHUNK = 0x06
    MESSAGE_INDEX = 0x07
    CHUNK_INDEX = 0x08
    ATTACHMENT = 0x09
    ATTACHMENT_INDEX = 0x0A
    STATISTICS = 0x0B
    METADATA = 0x0C
    METADATA_INDEX = 0x0D
    SUMMARY_OFFSET = 0x0E
    DATA_END = 0x0F


def record(op: Op, *parts: bytes) -> bytes:
    """Frame the joined ``parts`` as one record."""
    content = b"".join(parts)
    return _RECORD.pack(op, len(content)) + content


def sized(data: bytes) -> bytes:
    """Put a 32-bit length before ``data``."""
    return _LENGTH.pack(len(data)) + data


def text(value: str) -> bytes:
    """Encode a string."""
    return sized(value.encode())


def pairs(values: Mapping[str, str]) -> bytes:
    """Encode a map of strings."""
    return sized(b"".join(text(key) + text(value) for key, value in values.items()))


def header(library: str) -> bytes:
    """Return the first record of a file of the ros2 profile."""
    return record(Op.HEADER, text("ros2"), text(library))


def schema(schema_id: int, name: str, encoding: str, data: str) -> bytes:
    """Return a schema record."""
    return record(Op.SCHEMA, struct.pack("<H", schema_id), text(name), text(encoding), text(data))


def channel(channel_id: int, schema_id: int, topic: str, metadata: Mapping[str, str]) -> bytes:
    """Return the record of a topic whose messages are CDR."""
    return record(Op.CHANNEL, struct.pack("<HH", channel_id, schema_id), text(topic), text("cdr"), pairs(metadata))


def chunk(start_ns: int, end_ns: int, size: int, crc: int, compression: str, packed: bytes) -> bytes:
    """Return a chunk record; ``size`` and ``crc`` are those of the unpacked records."""
    head = struct.pack("<QQQI", start_ns, end_ns, size, crc)
    return record(Op.CHUNK, head, text(compression), struct.pack("<Q", len(packed)), packed)


def message_index(channel_id: int, entries: bytes) -> bytes:
    """Return one channel's index of a chunk; ``entries`` are pairs of log time and offset, 64 bits each."""
    return record(Op.MESSAGE_INDEX, struct.pack("<H", channel_id), sized(entries))


def chunk_index(
    span_ns: tuple[int, int],
    place: tuple[int, int],
    index_offsets: Sequence[tuple[int, int]],
    index_length: int,
    compression: str,
    sizes: tuple[int, int],
) -> bytes:
    """Return a chunk's entry in the summary: its span of time, (offset, length), index and (packed, unpacked) sizes."""
    offsets = b"".join(struct.pack("<HQ", channel_id, offset) for channel_id, offset in index_offsets)
    return record(
        Op.CHUNK_INDEX,
        struct.pack("<QQQQ", *span_ns, *place),
        sized(offsets),
        struct.pack("<Q", index_length),
        text(compression),
        struct.pack("<QQ", *sizes),
    )


def statistics(schemas: int, chunks: int, metadata: int, span_ns: tuple[int, int], counts: Mapping[int, int]) -> bytes:
    """Return the summary's counts; ``counts`` is messages by channel id."""
    head = struct.pack("<QHIIIIQQ", sum(counts.values()), schemas, len(counts), 0, metadata, chunks, *span_ns)
    return record(Op.STATISTICS, head, sized(b"".join(struct.pack("<HQ", key, value) for key, value in counts.items())))


def metadata_record(name: str, values: Mapping[str, str]) -> bytes:
    """Return a named map of strings."""
    return record(Op.METADATA, text(name), pairs(values))


def metadata_index(offset: int, length: int, name: str) -> bytes:
    """Return a metadata record's entry in the summary."""
    return record(Op.METADATA_INDEX, struct.pack("<QQ", offset, length), text(name))


def summary_offset(op: Op, start: int, length: int) -> bytes:
    """Return where the summary's group of records of one kind lies."""
    return record(Op.SUMMARY_OFFSET, struct.pack("<BQQ", op, start, length))


def data_end(crc: int) -> bytes:
    """Return the end of the data section; ``crc`` is that of every byte of the file up to here."""
    return record(Op.DATA_END, struct.pack("<I", crc))


def footer(summary_start: int, offsets_start: int, crc: int) -> bytes:
    """Return the last record; ``crc`` covers the summary and this record up to the checksum."""
    return record(Op.FOOTER, struct.pack("<QQI", summary_start, offsets_start, crc))


def footer_head(summary_start: int, offsets_start: int) -> bytes:
    """Return the part of the footer its own checksum covers."""
    return _RECORD.pack(Op.FOOTER, 20) + struct.pack("<QQ", summary_start, offsets_start)
