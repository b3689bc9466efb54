"""The end of an MCAP file: what it says of the rest, checked as far as it can be without reading that."""

import struct
import zlib
from typing import NamedTuple

from hslam_bags import mcap_parsing as parse
from hslam_bags.mcap_records import MAGIC, Op

_FOOTER = struct.Struct("<BQQQI")
_DATA_END = struct.Struct("<BQI")
_IN_SUMMARY = frozenset(
    {
        Op.SCHEMA,
        Op.CHANNEL,
        Op.STATISTICS,
        Op.CHUNK_INDEX,
        Op.ATTACHMENT_INDEX,
        Op.METADATA_INDEX,
        Op.SUMMARY_OFFSET,
    }
)


class Summary(NamedTuple):
    """What the end of a file tells."""

    data_end: int
    """Byte at which the data section's last record, its end mark, begins."""
    data_crc: int
    """Checksum of everything before that mark, 0 if there is none."""
    described: list[tuple[int, int, memoryview]]
    """Opcode, place and content of the schemas and channels."""
    chunks: dict[int, parse.ChunkIndex]
    """The chunks by the byte at which they begin; empty where the writer indexed none."""
    statistics: parse.Statistics | None

    @property
    def complete(self) -> bool:
        """Whether the data section need not be read to know what is in it: a writer may leave out what it likes."""
        if self.statistics is None:
            return False
        channels = any(op == Op.CHANNEL for op, _, _ in self.described)
        return not sum(self.statistics.counts.values()) or (bool(self.chunks) and channels)


def read_summary(data: memoryview) -> Summary | None:
    """Read the summary of a file, None if it was written without; raises ValueError where it is damaged or missing."""
    footer = len(data) - _FOOTER.size - len(MAGIC)
    if footer < len(MAGIC) or data[-len(MAGIC) :] != MAGIC:
        raise ValueError("the file's end is missing: it was not closed or is cut short")
    op, length, start, _, crc = _FOOTER.unpack_from(data, footer)
    if (op, length) != (Op.FOOTER, _FOOTER.size - 9):
        raise ValueError(f"byte {footer}: no footer is there")
    if start == 0:
        if crc and zlib.crc32(data[footer : footer + _FOOTER.size - 4]) != crc:
            raise ValueError("the footer has lost the summary's place")
        return None
    if not len(MAGIC) + _DATA_END.size <= start <= footer:
        raise ValueError(f"the footer points to byte {start}, outside the file")
    if crc and zlib.crc32(data[start : footer + _FOOTER.size - 4]) != crc:
        raise ValueError(f"the summary at byte {start} differs from its checksum")
    data_end = start - _DATA_END.size
    op, length, data_crc = _DATA_END.unpack_from(data, data_end)
    if (op, length) != (Op.DATA_END, 4):
        raise ValueError(f"byte {data_end}: the data section's end is not marked")
    summary = _contents(Summary(data_end, data_crc, [], {}, None), data, start, footer)
    _check_index(summary)
    return summary


def _contents(summary: Summary, data: memoryview, start: int, footer: int) -> Summary:
    """Return the summary with what its records tell."""
    statistics = None
    for op, offset, content in parse.records(data, start, footer):
        if op in (Op.SCHEMA, Op.CHANNEL):
            summary.described.append((op, offset, content))
        elif op == Op.CHUNK_INDEX:
            entry = parse.chunk_index(content)
            if summary.chunks.setdefault(entry.offset, entry) is not entry:
                raise ValueError(f"byte {offset}: the chunk at byte {entry.offset} is in the index twice")
        elif op == Op.STATISTICS:
            statistics = parse.statistics(content)
        elif op not in _IN_SUMMARY and op < parse.OF_USERS:
            raise ValueError(f"byte {offset}: opcode {op} does not belong into a summary")
    return summary._replace(statistics=statistics)


def _check_index(summary: Summary) -> None:
    """Raise ValueError where the index does not agree with the file's length, the statistics or itself."""
    reached = len(MAGIC)
    for entry in sorted(summary.chunks.values(), key=lambda entry: entry.offset):
        if not reached <= entry.offset < entry.offset + entry.length <= summary.data_end:
            raise ValueError(f"the index tells of a chunk at byte {entry.offset}, where there can be none")
        reached = entry.offset + entry.length
    counted = summary.statistics.chunk_count if summary.statistics else len(summary.chunks)
    if summary.chunks and len(summary.chunks) != counted:
        raise ValueError(f"the index has {len(summary.chunks)} chunks, the statistics {counted}")
