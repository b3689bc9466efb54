"""Walking over an MCAP file's records, guided by its index where it has one, and past damage to what follows it.

A chunk says three times where it ends: by its record's length, by the length of what is packed in it, and in the index;
its checksum decides which of them is right, and whether it is a chunk at all.
"""

import re
import struct
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from hslam_bags import mcap_parsing as parse
from hslam_bags.mcap_chunk import is_verified
from hslam_bags.mcap_records import MAGIC, MESSAGE, Op

_HEAD = struct.Struct("<BQ")
_IN_DATA = frozenset(
    {Op.HEADER, Op.SCHEMA, Op.CHANNEL, Op.MESSAGE, Op.CHUNK, Op.MESSAGE_INDEX, Op.ATTACHMENT, Op.METADATA, Op.DATA_END}
)
_MAY_BEGIN = re.compile(rb"(?=[\x03-\x07\x09\x0c\x0f].{5}\0\0\0)", re.DOTALL)
"""The opcode and length of a record of less than a terabyte, at any byte."""
_RUN = 3
"""So many records in a row are none by chance."""

Tell = Callable[[int, str], None]
"""Told of damage: the byte and what is wrong."""


class Found(NamedTuple):
    """A record: its opcode, or that of a chunk where only the opcode was damaged; ``end`` is the byte after it."""

    op: int
    offset: int
    end: int
    whole: bool = True
    """False: a chunk whose end is missing."""


def walk(data: memoryview, end: int, index: Mapping[int, parse.ChunkIndex], tell: Tell) -> Iterator[Found]:
    """Yield the records of the data section, which ends at byte ``end`` at the latest.

    Damage goes to ``tell``; the walk goes on with the next record that can be found behind it.
    """
    at = len(MAGIC)
    if data[at : at + 1] != bytes([Op.HEADER]):
        tell(at, "the file's header is missing")
    loose = not index
    begins = [*sorted(index), end]
    number = 0
    while at < end:
        while begins[number] < at:
            tell(begins[number], "the index tells of a chunk where none begins")
            number += 1
        entry = index.get(at)
        number += entry is not None
        limit = end if entry else begins[number]
        try:
            found = _record(data, at, limit, entry, tell)
        except ValueError as error:
            tell(at, str(error))
            follows = _resume(data, at + 1, begins[number], loose=loose)
            if follows == end == len(data) and data[at] == Op.CHUNK:
                yield Found(Op.CHUNK, at, end, whole=False)
            at = follows
            continue
        if found.op == Op.DATA_END and not index:
            break
        loose = found.op == Op.MESSAGE or (loose and found.op != Op.CHUNK)
        yield found
        at = found.end


def _record(data: memoryview, at: int, end: int, entry: parse.ChunkIndex | None, tell: Tell) -> Found:
    """Return the record at a byte, which the index may have told of; ValueError if there is none."""
    if at + _HEAD.size > end:
        raise ValueError("a record is cut short")
    if entry is not None and (indexed := _indexed(data, at, entry, tell)) is not None:
        return indexed
    op, length = _HEAD.unpack_from(data, at)
    after = at + _HEAD.size + length
    if after > end:
        return _chunk_of_other_length(data, at, end, f"a record of {length} bytes reaches past the end", tell)
    content = data[at + _HEAD.size : after]
    if op in (Op.CHUNK, Op.MESSAGE):
        if op == Op.CHUNK and parse.as_chunk(content) is None:
            return _chunk_of_other_length(data, at, end, "a chunk has not the length it says", tell, after)
        return Found(op, at, after)
    if parse.as_chunk(content) is not None and is_verified(content):
        tell(at, f"opcode {op} is not that of the chunk there, which is whole")
        return Found(Op.CHUNK, at, after)
    if (op not in _IN_DATA and op < parse.OF_USERS) or (op == Op.DATA_END and length != 4):
        raise ValueError(f"opcode {op} does not belong there")
    return Found(op, at, after)


def _indexed(data: memoryview, at: int, entry: parse.ChunkIndex, tell: Tell) -> Found | None:
    """Return the chunk at a byte that the index tells of; None if there is none."""
    op, length = _HEAD.unpack_from(data, at)
    found = Found(Op.CHUNK, at, at + entry.length)
    if op == Op.CHUNK and _HEAD.size + length == entry.length:
        return found
    if is_verified(data[at + _HEAD.size : found.end]):
        tell(at, f"opcode {op} and length {length} are not those of the chunk there, which is whole")
        return found
    tell(at, "the index tells of a chunk where none begins")
    return None


def _chunk_of_other_length(
    data: memoryview, at: int, end: int, problem: str, tell: Tell, after: int | None = None
) -> Found:
    """Return the chunk at a byte by the length of what is packed in it; ValueError, the problem, if that is no better.

    ``after`` is where its record's length would end it, if that is within the file.
    """
    content = data[at + _HEAD.size : end]
    try:
        packed_end = parse.chunk_head(content).end
    except ValueError:
        packed_end = len(content) + 1
    if packed_end <= len(content) and is_verified(content[:packed_end]):
        tell(at, f"{problem}; it is whole")
        return Found(Op.CHUNK, at, at + _HEAD.size + packed_end)
    if after is not None and data[at] == Op.CHUNK and _run_begins(data, after, end, loose=False):
        return Found(Op.CHUNK, at, after)
    raise ValueError(problem)


def _resume(data: memoryview, at: int, end: int, *, loose: bool) -> int:
    """Return where records begin again, at ``end`` at the latest; messages outside chunks only if ``loose``."""
    for match in _MAY_BEGIN.finditer(data[:end], at):
        if _run_begins(data, match.start(), end, loose=loose):
            return match.start()
    return end


def _run_begins(data: memoryview, at: int, end: int, *, loose: bool) -> bool:
    """Whether records follow one another from a byte on, or a chunk is there that looks like one."""
    for _ in range(_RUN):
        if at == end:
            break
        if at + _HEAD.size > end:
            return False
        op, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size + length
        if at > end or not _looks_right(op, data[at - length : at], loose=loose):
            return False
        if op in (Op.CHUNK, Op.DATA_END):
            break
    return True


def _looks_right(op: int, content: memoryview, *, loose: bool) -> bool:
    """Whether the content of a record is such as its opcode says, as far as lengths tell."""
    if op == Op.CHUNK:
        return parse.as_chunk(content) is not None
    if op == Op.MESSAGE:
        return loose and len(content) >= MESSAGE.size - _HEAD.size
    return op in _IN_DATA and (op != Op.DATA_END or len(content) == 4)
