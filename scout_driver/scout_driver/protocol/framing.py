"""Frames on the wire: ``0x01 | LEN_lo | LEN_hi | TYPE | DATA | CKSUM | 0x5C``.

LEN is little-endian and counts TYPE, DATA and CKSUM; CKSUM is the sum of everything before it, modulo 256.
There is no byte stuffing, so start and end bytes also occur inside DATA and frames are cut by length.
"""

from typing import NamedTuple

from scout_driver.errors import ProtocolError

START = 0x01
END = 0x5C
OVERHEAD = 4
"""A whole frame is LEN + 4 bytes: start, two of LEN, end."""
LENGTH_MIN = 2
LENGTH_MAX = 256
"""No reply or command is longer; a larger LEN is noise, and waiting for it would deafen the reader."""


class Frame(NamedTuple):
    """One frame's content: TYPE and DATA."""

    kind: int
    data: bytes = b""


def encode_frame(frame: Frame) -> bytes:
    """Return the bytes of ``frame``; raises ProtocolError if TYPE or the length does not fit."""
    length = len(frame.data) + 2
    if not 0 <= frame.kind <= 0xFF or length > LENGTH_MAX:
        raise ProtocolError(f"no frame can hold type {frame.kind} with {len(frame.data)} bytes of data")
    body = bytes((START, length & 0xFF, length >> 8, frame.kind)) + frame.data
    return body + bytes((sum(body) & 0xFF, END))


class FrameParser:
    """Cuts a stream of bytes into frames and finds its way back after any garbage."""

    def __init__(self) -> None:
        """Start with an empty buffer."""
        self._buffer = bytearray()
        self.discarded = 0
        """Bytes thrown away so far because no good frame began there."""

    @property
    def pending(self) -> int:
        """The number of bytes held that may still become a frame."""
        return len(self._buffer)

    def feed(self, data: bytes) -> list[Frame]:
        """Return the frames completed by ``data``, oldest first."""
        self._buffer += data
        frames = []
        while (frame := self._cut()) is not None:
            frames.append(frame)
        return frames

    def line_silent(self) -> list[Frame]:
        """Give up the frame under way, for the rest of it will not come, and return what was hidden behind it."""
        frames = []
        while self._buffer:
            self._drop(1)
            frames += self.feed(b"")
        return frames

    def clear(self) -> None:
        """Forget everything held."""
        self._drop(len(self._buffer))

    def _cut(self) -> Frame | None:
        """Take the first good frame off the buffer; None when more bytes are needed."""
        buffer = self._buffer
        while True:
            start = buffer.find(START)
            self._drop(len(buffer) if start < 0 else start)
            if len(buffer) < 3:
                return None
            length = buffer[1] | buffer[2] << 8
            if LENGTH_MIN <= length <= LENGTH_MAX:
                whole = length + OVERHEAD
                if len(buffer) < whole:
                    return None
                if buffer[whole - 1] == END and buffer[whole - 2] == sum(buffer[: whole - 2]) & 0xFF:
                    frame = Frame(buffer[3], bytes(buffer[4 : whole - 2]))
                    del buffer[:whole]
                    return frame
            self._drop(1)

    def _drop(self, count: int) -> None:
        """Throw ``count`` bytes away and count them."""
        self.discarded += count
        del self._buffer[:count]
