"""Reading an MCAP file: by its summary where it has one, by a walk over its records where it is damaged."""

import mmap
import re
import struct
import zlib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from hslam_bags import mcap_parsing as parse
from hslam_bags.errors import BagError
from hslam_bags.mcap_records import MAGIC, Op
from hslam_bags.qos import qos_from_yaml
from hslam_bags.stored import Complaint, Iteration, StoredMessage, StoredTopic, in_time_order

_FOOTER_SIZE = 9 + 20 + len(MAGIC)
_PACKED = re.compile(rb"\x04\0\0\0zstd|\x03\0\0\0lz4")
_BEFORE_COMPRESSION = 9 + 28


class _Piece(NamedTuple):
    """A chunk, or a message outside chunks, by where its record begins."""

    start_ns: int
    end_ns: int
    offset: int


class McapStorage:
    """One MCAP file, mapped into memory; only the chunks in use are unpacked."""

    def __init__(self, path: Path, complain: Complaint) -> None:
        """Open ``path``; BagError if nothing of it can be read, what can be stepped over goes to ``complain``."""
        self.path = path
        self._complain = complain
        self._schemas: dict[int, parse.SchemaRecord] = {}
        self._channels: dict[int, parse.ChannelRecord] = {}
        self._topics: dict[int, StoredTopic] = {}
        self._pieces: list[_Piece] = []
        self._counts: dict[int, int] = {}
        self._reached = 0
        self._data = self._map()
        if self._data[: len(MAGIC)] != MAGIC:
            raise BagError(path, "at byte 0", "is no MCAP file")
        try:
            whole = self._read_summary()
        except (ValueError, struct.error) as error:
            complain(BagError(path, "summary", str(error)))
            whole = False
        if not whole:
            self._walk()

    @property
    def topics(self) -> tuple[StoredTopic, ...]:
        """The topics, in the order they were added."""
        return tuple(self._topics[key] for key in sorted(self._topics))

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """First and last log time, None if there is no message."""
        if not self._pieces:
            return None
        return min(piece.start_ns for piece in self._pieces), max(piece.end_ns for piece in self._pieces)

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic."""
        totals = dict.fromkeys((topic.name for topic in self.topics), 0)
        for key, count in self._counts.items():
            if key in self._topics:
                totals[self._topics[key].name] += count
        return totals

    def messages(self, topics: Collection[str], start_ns: int, end_ns: int) -> Iterator[StoredMessage]:
        """Yield the messages of ``topics`` with start <= log time < end, in order of log time."""
        wanted = {key: topic for key, topic in self._topics.items() if topic.name in topics}
        pieces = [piece for piece in self._pieces if piece.start_ns < end_ns and piece.end_ns >= start_ns]
        for message in in_time_order((piece.start_ns, self._iteration(piece, wanted)) for piece in pieces):
            if start_ns <= message.log_ns < end_ns:
                yield message

    def close(self) -> None:
        """Unmap the file."""
        self._data.release()

    def _map(self) -> memoryview:
        try:
            with self.path.open("rb") as file:
                if self.path.stat().st_size == 0:
                    raise BagError(self.path, "", "is empty")
                return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
        except OSError as error:
            raise BagError(self.path, "", f"cannot be read: {error.strerror}") from error

    def _read_summary(self) -> bool:
        """Take everything from the summary; False if the file has none, ValueError if it is damaged."""
        data, size = self._data, len(self._data)
        if size < len(MAGIC) + _FOOTER_SIZE or data[-len(MAGIC) :] != MAGIC:
            raise ValueError("the file's end is missing: it was not closed or is cut short")
        footer = size - _FOOTER_SIZE
        start, _, crc = struct.unpack_from("<QQI", data, footer + 9)
        if start == 0:
            return False
        if not len(MAGIC) <= start <= footer:
            raise ValueError(f"the footer points to byte {start}, outside the file")
        if crc and zlib.crc32(data[start : footer + 25]) != crc:
            raise ValueError(f"the summary at byte {start} differs from its checksum")
        counted = None
        for op, _, content in parse.records(data, start, footer):
            if op == Op.CHUNK_INDEX:
                self._pieces.append(_Piece(*parse.chunk_index(content)))
            elif op == Op.STATISTICS:
                counted = parse.statistics(content)[1]
            else:
                self._note(op, content)
        total = sum(counted.values()) if counted is not None else -1
        # A summary may leave out what it likes; without these the file must be walked.
        whole = counted is not None and (total == 0 or (bool(self._pieces) and bool(self._channels)))
        if whole and counted is not None:
            self._counts = counted
        return whole

    def _note(self, op: int, content: memoryview) -> None:
        """Keep a schema or a channel."""
        if op == Op.SCHEMA:
            entry = parse.schema(content)
            self._schemas[entry.id] = entry
        elif op == Op.CHANNEL:
            self._note_channel(parse.channel(content))

    def _note_channel(self, channel: parse.ChannelRecord) -> None:
        """Keep a channel whose messages are CDR of a known type."""
        if channel.id in self._channels:
            return
        self._channels[channel.id] = channel
        schema = self._schemas.get(channel.schema_id)
        place = f"topic {channel.topic}"
        if channel.encoding != "cdr" or schema is None:
            what = f"messages are '{channel.encoding}', not cdr" if schema else "has no type"
            self._complain(BagError(self.path, place, what))
            return
        try:
            offers = qos_from_yaml(channel.metadata.get("offered_qos_profiles", ""))
        except ValueError as error:
            self._complain(BagError(self.path, place, str(error)))
            offers = ()
        type_hash = channel.metadata.get("topic_type_hash", "")
        self._topics[channel.id] = StoredTopic(
            channel.topic, schema.name, offers, type_hash, schema.encoding, schema.text
        )

    def _walk(self) -> None:
        """Take everything from the records themselves, stepping over damage to the next chunk."""
        self._pieces.clear()
        self._counts.clear()
        at: int | None = len(MAGIC)
        while at is not None and at < len(self._data):
            self._reached = at
            try:
                self._walk_from(at)
            except ValueError as error:
                self._complain(BagError(self.path, "", str(error)))
                self._take_cut_chunk(self._reached)
                at = self._next_chunk(self._reached + 1)
            else:
                return

    def _walk_from(self, begin: int) -> None:
        """Walk the records from ``begin`` on, noting how far it came; ValueError at damage."""
        for op, offset, content in parse.records(self._data, begin, len(self._data)):
            if op in (Op.DATA_END, Op.FOOTER):
                return
            if not parse.is_record(op):
                raise ValueError(f"byte {offset}: opcode {op} does not exist")
            self._walk_record(op, offset, content)
            self._reached = offset + 9 + len(content)

    def _walk_record(self, op: int, offset: int, content: memoryview) -> None:
        """Count one record of the data section; damage inside a chunk is told and the chunk left out."""
        if op == Op.MESSAGE:
            channel_id, log_ns, _, _ = parse.message(content)
            self._pieces.append(_Piece(log_ns, log_ns, offset))
            self._counts[channel_id] = self._counts.get(channel_id, 0) + 1
        elif op == Op.CHUNK:
            try:
                self._count_chunk(offset, parse.unpack_chunk(parse.chunk_head(content), content))
            except ValueError as error:
                self._complain(BagError(self.path, f"chunk at byte {offset}", str(error)))
        else:
            self._note(op, content)

    def _count_chunk(self, offset: int, unpacked: bytes) -> None:
        """Count a chunk's messages and keep its schemas and channels."""
        times = []
        for op, _, content in parse.records(memoryview(unpacked), 0, len(unpacked)):
            if op == Op.MESSAGE:
                channel_id, log_ns, _, _ = parse.message(content)
                times.append(log_ns)
                self._counts[channel_id] = self._counts.get(channel_id, 0) + 1
            else:
                self._note(op, content)
        if times:
            self._pieces.append(_Piece(min(times), max(times), offset))

    def _take_cut_chunk(self, offset: int) -> None:
        """Keep the beginning of a last chunk whose end is missing."""
        if offset + 9 < len(self._data) and self._data[offset] == Op.CHUNK:
            try:
                self._count_chunk(offset, self._unpacked(offset))
            except ValueError:
                return

    def _next_chunk(self, at: int) -> int | None:
        """Return where the next packed chunk's record begins, found by the name of its packing; None: nowhere."""
        for found in _PACKED.finditer(self._data, at + _BEFORE_COMPRESSION):
            offset = found.start() - _BEFORE_COMPRESSION
            (length,) = struct.unpack_from("<Q", self._data, offset + 1)
            if self._data[offset] == Op.CHUNK and offset + 9 + length <= len(self._data):
                return offset
        return None

    def _unpacked(self, offset: int) -> bytes:
        """Return the records of the chunk at ``offset``, as many as there are."""
        (length,) = struct.unpack_from("<Q", self._data, offset + 1)
        content = self._data[offset + 9 : offset + 9 + length]
        head = parse.chunk_head(content)
        return parse.unpack_chunk(head, content) if len(content) == length else parse.unpack_cut_chunk(head, content)

    def _iteration(self, piece: _Piece, wanted: dict[int, StoredTopic]) -> Iteration:
        """Return what yields a piece's messages in order of log time."""

        def iterate() -> Iterator[StoredMessage]:
            try:
                found = self._piece_messages(piece, wanted)
            except (ValueError, struct.error) as error:
                self._complain(BagError(self.path, f"chunk at byte {piece.offset}", str(error)))
                return
            yield from sorted(found, key=lambda message: message.log_ns)

        return iterate

    def _piece_messages(self, piece: _Piece, wanted: dict[int, StoredTopic]) -> list[StoredMessage]:
        """Return the wanted messages of a piece as they lie in it."""
        if self._data[piece.offset] == Op.CHUNK:
            data = memoryview(self._unpacked(piece.offset))
            begin, end = 0, len(data)
        else:
            data, begin = self._data, piece.offset
            end = begin + 9 + struct.unpack_from("<Q", data, begin + 1)[0]
        found = []
        for op, _, content in parse.records(data, begin, end):
            if op == Op.MESSAGE:
                channel_id, log_ns, publish_ns, raw = parse.message(content)
                if channel_id in wanted:
                    topic = wanted[channel_id]
                    found.append(StoredMessage(topic.name, topic.type_name, raw, log_ns, publish_ns))
                elif channel_id not in self._channels:
                    raise ValueError(f"a message is of channel {channel_id}, which the file does not describe")
        return found
