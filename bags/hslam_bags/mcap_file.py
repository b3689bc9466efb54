"""An MCAP file that is whole after every chunk: a killed recorder leaves a file any MCAP reader opens.

Each chunk is written together with the summary and the end of the file, in one call; the next chunk takes the place
of that summary. A write that fails (a full disk) puts the former summary back into the blocks it had already, which
needs no new space.
"""

import itertools
import os
import sys
import zlib
from array import array
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from backports import zstd

from hslam_bags import mcap_records as mcap
from hslam_bags.errors import BagError
from hslam_bags.mcap_records import Op

LIBRARY = "hslam_bags 1"


class _Written(NamedTuple):
    """What is on disk; replaced as one when a chunk is."""

    counts: dict[int, int]
    """Messages by channel."""
    span_ns: tuple[int, int] | None
    """First and last log time."""
    chunk_indices: list[bytes]


class McapFile:
    """Writes schemas, channels and messages; `flush` ends the chunk in progress."""

    def __init__(self, path: Path, *, chunk_bytes: int, compression: str) -> None:
        """Create ``path`` (BagError if it exists or cannot be made); a chunk ends at ``chunk_bytes`` before packing."""
        self.path = path
        self._chunk_bytes = chunk_bytes
        self._compression = compression
        self._chunk = bytearray()
        self._entries: dict[int, array[int]] = {}
        self._schemas: list[bytes] = []
        self._channels: list[bytes] = []
        self._unwritten: list[bytes] = []
        self._written = _Written({}, None, [])
        self._metadata_indices: list[bytes] = []
        self._end = 0
        self._crc = 0
        self._tail = b""
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        except OSError as error:
            raise BagError(path, "", f"cannot be created: {error.strerror}") from error
        self._append(mcap.MAGIC + mcap.header(LIBRARY), self._written)

    @property
    def size(self) -> int:
        """Bytes on disk, the summary left out."""
        return self._end

    @property
    def counts(self) -> dict[int, int]:
        """Messages on disk by channel."""
        return self._written.counts

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """First and last log time on disk."""
        return self._written.span_ns

    @property
    def message_count(self) -> int:
        """Messages on disk."""
        return sum(self.counts.values())

    @property
    def pending(self) -> dict[int, int]:
        """Messages by channel in the chunk in progress, lost if the process dies now."""
        return {key: len(entries) // 2 for key, entries in self._entries.items() if entries}

    def add_schema(self, name: str, encoding: str, definition: str) -> int:
        """Add a type and return its id."""
        self._schemas.append(mcap.schema(len(self._schemas) + 1, name, encoding, definition))
        self._unwritten.append(self._schemas[-1])
        return len(self._schemas)

    def add_channel(self, topic: str, schema_id: int, metadata: Mapping[str, str]) -> int:
        """Add a topic and return its id."""
        channel_id = len(self._channels) + 1
        self._channels.append(mcap.channel(channel_id, schema_id, topic, metadata))
        self._unwritten.append(self._channels[-1])
        self._written.counts[channel_id] = 0
        self._entries[channel_id] = array("Q")
        return channel_id

    def write(self, channel_id: int, log_ns: int, publish_ns: int, data: bytes) -> bool:
        """Add a message; True if that ended a chunk. The heart of recording, kept to a few calls."""
        chunk, entries = self._chunk, self._entries[channel_id]
        sequence = (self.counts[channel_id] + (len(entries) >> 1)) & 0xFFFFFFFF
        offset = len(chunk)
        # Whole records and whole entries, in this order: Ctrl-C between two of these lines leaves nothing half done.
        chunk += mcap.MESSAGE.pack(Op.MESSAGE, 22 + len(data), channel_id, sequence, log_ns, publish_ns) + data
        entries.extend((log_ns, offset))
        if len(chunk) < self._chunk_bytes:
            return False
        self.flush()
        return True

    def flush(self) -> None:
        """Write the chunk in progress and make the file whole; BagError, and the file as before, if it cannot be."""
        if not self._chunk and not self._unwritten:
            return
        records, after = [*self._unwritten], self._written
        if self._chunk:
            records, after = self._with_chunk(records)
        self._append(b"".join(records), after)
        self._unwritten.clear()
        self._chunk = bytearray()
        for entries in self._entries.values():
            del entries[:]

    def _with_chunk(self, records: list[bytes]) -> tuple[list[bytes], _Written]:
        """Return ``records`` with the chunk in progress and its indices behind, and what is on disk after them."""
        offset = self._end + sum(map(len, records))
        size = len(self._chunk)
        packed = zstd.compress(self._chunk, level=1) if self._compression == "zstd" else bytes(self._chunk)
        used = {key: entries for key, entries in self._entries.items() if entries}
        span = min(min(entries[::2]) for entries in used.values()), max(max(entries[::2]) for entries in used.values())
        chunk = mcap.chunk(*span, size, zlib.crc32(self._chunk), self._compression, packed)
        indices = [mcap.message_index(key, _little_endian(entries)) for key, entries in used.items()]
        starts = itertools.accumulate(map(len, indices), initial=offset + len(chunk))
        index = mcap.chunk_index(
            span,
            (offset, len(chunk)),
            list(zip(used, starts, strict=False)),
            sum(map(len, indices)),
            self._compression,
            (len(packed), size),
        )
        low, high = self._written.span_ns or span
        counts = {key: self.counts.get(key, 0) + len(entries) // 2 for key, entries in self._entries.items()}
        after = _Written(counts, (min(low, span[0]), max(high, span[1])), [*self._written.chunk_indices, index])
        return [*records, chunk, *indices], after

    def close(self, metadata: Mapping[str, str] | None = None) -> None:
        """Flush, add ``metadata`` under rosbag2's name and close; BagError if it cannot all be written."""
        try:
            self.flush()
            if metadata:
                record = mcap.metadata_record("rosbag2", metadata)
                self._metadata_indices.append(mcap.metadata_index(self._end, len(record), "rosbag2"))
                self._append(record, self._written)
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Close without writing; what is on disk stays as it is."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def _append(self, data: bytes, after: _Written) -> None:
        """Write ``data`` over the end of the file, followed by the new end, which tells what there is ``after`` it."""
        crc = zlib.crc32(data, self._crc)
        tail = self._summary(self._end + len(data), crc, after)
        try:
            _write_all(self._file, data + tail, self._end)
        except OSError as error:
            # The former end goes back to where it was: those blocks are still the file's.
            _write_all(self._file, self._tail, self._end)
            os.ftruncate(self._file, self._end + len(self._tail))
            place = f"at byte {self._end + len(self._tail)}"
            raise BagError(self.path, place, f"{(error.strerror or 'write failed').lower()}") from error
        self._end, self._crc, self._tail, self._written = self._end + len(data), crc, tail, after

    def _summary(self, data_end: int, data_crc: int, written: _Written) -> bytes:
        """Return all that follows the data, which end at byte ``data_end`` and have the checksum ``data_crc``."""
        span = written.span_ns or (0, 0)
        chunks, notes = len(written.chunk_indices), len(self._metadata_indices)
        groups = (
            (Op.SCHEMA, b"".join(self._schemas)),
            (Op.CHANNEL, b"".join(self._channels)),
            (Op.STATISTICS, mcap.statistics(len(self._schemas), chunks, notes, span, written.counts)),
            (Op.CHUNK_INDEX, b"".join(written.chunk_indices)),
            (Op.METADATA_INDEX, b"".join(self._metadata_indices)),
        )
        end_mark = mcap.data_end(data_crc)
        start = at = data_end + len(end_mark)
        offsets = b""
        for op, group in groups:
            if group:
                offsets += mcap.summary_offset(op, at, len(group))
            at += len(group)
        summary = b"".join(group for _, group in groups) + offsets
        crc = zlib.crc32(summary + mcap.footer_head(start, at))
        return end_mark + summary + mcap.footer(start, at, crc) + mcap.MAGIC


def _write_all(file: int, data: bytes, offset: int) -> None:
    """Write everything at ``offset``; OSError if the system takes no more."""
    rest = memoryview(data)
    while rest:
        written = os.pwrite(file, rest, offset)
        rest, offset = rest[written:], offset + written


def _little_endian(entries: "array[int]") -> bytes:
    """Return 64-bit values in MCAP's byte order."""
    if sys.byteorder == "big":
        entries = array("Q", entries)
        entries.byteswap()
    return entries.tobytes()
