"""Reading an MCAP file: by its summary where it has one, by a walk over its records where it is damaged."""

import mmap
import struct
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from hslam_bags import mcap_parsing as parse
from hslam_bags.errors import BagError
from hslam_bags.mcap_chunk import read_chunk, read_cut_chunk
from hslam_bags.mcap_records import MAGIC, Op
from hslam_bags.mcap_summary import Summary, read_summary
from hslam_bags.mcap_walk import Found, walk
from hslam_bags.qos import qos_from_yaml
from hslam_bags.stored import Complaint, Iteration, StoredMessage, StoredTopic, in_time_order

_RECORD_HEAD = 9


class _Piece(NamedTuple):
    """A chunk, or a message outside chunks: its span of time (ns) and its record."""

    start_ns: int
    end_ns: int
    record: Found


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
        self._read: dict[int, Counter[int]] = {}
        """Messages by channel of each chunk that was read, or zero if it could not be, by its place."""
        self._single: Counter[int] = Counter()
        """Messages outside chunks by channel."""
        self._counted = False
        self._data = self._map()
        if self._data[: len(MAGIC)] != MAGIC:
            raise BagError(path, "at byte 0", "is no MCAP file")
        self._summary = self._read_summary()
        self._index = self._summary.chunks if self._summary and self._summary.complete else {}
        self._read_data()
        self._check_counts()

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
        """Messages by topic: as they were found, else as the file counts them."""
        counted = self._found_counts()
        if counted is None:
            counted = (
                Counter(self._summary.statistics.counts) if self._summary and self._summary.statistics else Counter()
            )
        totals = dict.fromkeys((topic.name for topic in self.topics), 0)
        for key, topic in self._topics.items():
            totals[topic.name] += counted[key]
        return totals

    def messages(self, topics: Collection[str], start_ns: int, end_ns: int) -> Iterator[StoredMessage]:
        """Yield the messages of ``topics`` with start <= log time < end, in order of log time."""
        wanted = {key: topic for key, topic in self._topics.items() if topic.name in topics}
        pieces = [piece for piece in self._pieces if piece.start_ns < end_ns and piece.end_ns >= start_ns]
        for message in in_time_order((piece.start_ns, self._iteration(piece, wanted)) for piece in pieces):
            if start_ns <= message.log_ns < end_ns:
                yield message
        self._check_counts()

    def check(self) -> None:
        """Compare everything with the checksum over the whole, where the file has one."""
        if self._summary and self._summary.data_crc:
            end = self._summary.data_end
            if zlib.crc32(self._data[:end]) != self._summary.data_crc:
                self._complain(BagError(self.path, f"before byte {end}", "the data differ from their checksum"))

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

    def _read_summary(self) -> Summary | None:
        """Return the summary, None where there is none or it is damaged."""
        try:
            return read_summary(self._data)
        except (ValueError, struct.error) as error:
            self._complain(BagError(self.path, "summary", str(error)))
            return None

    def _read_data(self) -> None:
        """Find the pieces, and what describes them."""
        described = self._summary.described if self._summary else []
        for op, offset, content in sorted(described, key=lambda record: record[0] == Op.CHANNEL):
            self._note(op, offset, content)
        end = self._summary.data_end if self._summary else len(self._data)
        for found in walk(self._data, end, self._index, self._tell):
            entry = self._index.get(found.offset)
            if found.op == Op.CHUNK and entry is not None:
                self._pieces.append(_Piece(entry.start_ns, entry.end_ns, found))
            elif found.op == Op.CHUNK:
                self._read_unindexed(found)
            elif found.op == Op.MESSAGE:
                self._note_message(found)
            else:
                self._note(found.op, found.offset, self._content(found))

    def _tell(self, offset: int, problem: str) -> None:
        self._complain(BagError(self.path, f"at byte {offset}", problem))

    def _content(self, found: Found) -> memoryview:
        return self._data[found.offset + _RECORD_HEAD : found.end]

    def _note_message(self, found: Found) -> None:
        """Keep the place of a message outside chunks."""
        try:
            channel_id, log_ns, _, _ = parse.message(self._content(found))
        except ValueError as error:
            self._tell(found.offset, str(error))
            return
        self._pieces.append(_Piece(log_ns, log_ns, found))
        self._single[channel_id] += 1

    def _note(self, op: int, offset: int, content: memoryview) -> None:
        """Keep a schema or a channel; one that is damaged costs no more than itself."""
        try:
            if op == Op.SCHEMA:
                entry = parse.schema(content)
                self._schemas.setdefault(entry.id, entry)
            elif op == Op.CHANNEL:
                self._note_channel(parse.channel(content))
        except (ValueError, struct.error) as error:
            self._tell(offset, f"the description of a topic or type is damaged: {error}")

    def _note_channel(self, channel: parse.ChannelRecord) -> None:
        """Keep a channel whose messages are CDR of a known type."""
        place = f"topic {channel.topic}"
        if (known := self._channels.setdefault(channel.id, channel)) is not channel:
            if known != channel:
                self._complain(BagError(self.path, place, f"has the number {channel.id} of topic {known.topic}"))
            return
        schema = self._schemas.get(channel.schema_id)
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

    def _read_unindexed(self, found: Found) -> None:
        """Count the messages of a chunk that no index tells of, and keep what it describes."""
        if self._index:
            self._tell(found.offset, "the chunk there is not in the index")
        messages = self._chunk_messages(found)
        if messages:
            times = [log_ns for _, log_ns, _, _ in messages]
            self._pieces.append(_Piece(min(times), max(times), found))

    def _chunk_messages(self, found: Found) -> list[tuple[int, int, int, bytes]]:
        """Return (channel, log time, publish time, data) of a chunk's messages; what is damaged is told."""
        messages, strangers = [], 0
        try:
            unpacked = self._unpacked(found)
            for op, _, inner in parse.records(memoryview(unpacked), 0, len(unpacked)):
                if op == Op.MESSAGE:
                    messages.append(parse.message(inner))
                elif op in (Op.SCHEMA, Op.CHANNEL):
                    self._note(op, found.offset, inner)
                else:
                    strangers += op < parse.OF_USERS
        except (ValueError, struct.error) as error:
            self._tell_chunk(found, str(error))
        if strangers:
            self._tell_chunk(found, f"{strangers} records are of kinds that do not belong there")
        self._read[found.offset] = Counter(channel_id for channel_id, _, _, _ in messages)
        return messages

    def _unpacked(self, found: Found) -> bytes:
        """Return a chunk's records; ValueError if they are damaged."""
        if not found.whole:
            return read_cut_chunk(self._content(found))
        unpacked, problem = read_chunk(self._content(found), self._index.get(found.offset))
        if problem:
            self._tell_chunk(found, problem)
        return unpacked

    def _tell_chunk(self, found: Found, problem: str) -> None:
        self._complain(BagError(self.path, f"chunk at byte {found.offset}", problem))

    def _iteration(self, piece: _Piece, wanted: dict[int, StoredTopic]) -> Iteration:
        """Return what yields a piece's messages in order of log time."""

        def iterate() -> Iterator[StoredMessage]:
            if piece.record.op == Op.CHUNK:
                messages = self._chunk_messages(piece.record)
            else:
                messages = [parse.message(self._content(piece.record))]
            found = [
                StoredMessage(topic.name, topic.type_name, raw, log_ns, publish_ns)
                for channel_id, log_ns, publish_ns, raw in messages
                if (topic := wanted.get(channel_id)) is not None
            ]
            yield from sorted(found, key=lambda message: message.log_ns)

        return iterate

    def _found_counts(self) -> Counter[int] | None:
        """Return the messages by channel once every chunk was read, None before."""
        chunks = [piece.record.offset for piece in self._pieces if piece.record.op == Op.CHUNK]
        if any(offset not in self._read for offset in chunks):
            return None
        return sum((self._read[offset] for offset in chunks), Counter(self._single))

    def _check_counts(self) -> None:
        """Once everything was read, tell what is not there or is of no topic."""
        found = self._found_counts()
        if found is None or self._counted:
            return
        self._counted = True
        counted = self._summary.statistics.counts if self._summary and self._summary.statistics else {}
        for key in sorted(found.keys() | counted.keys()):
            name = self._channels[key].topic if key in self._channels else f"{key}, which the file does not describe"
            if found[key] != counted.get(key, found[key]):
                lost = f"{found[key]} of the {counted[key]} messages that the file counts are there"
                self._complain(BagError(self.path, f"topic {name}", lost))
            elif found[key] and key not in self._channels:
                self._complain(BagError(self.path, f"topic {name}", f"{found[key]} messages are of no known topic"))
