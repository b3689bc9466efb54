"""The emulated serial line: every byte takes its time, in both directions, and some of them never arrive.

Driven by whoever owns the clock: a loop on real time with a pseudo-terminal or a socket, or a test that
jumps from event to event.
"""

from collections import deque

from scout_driver.emulator.base import MOTION, EmulatedBase
from scout_driver.emulator.config import EmulatorConfig
from scout_driver.emulator.faults import Faults, ReplyFault
from scout_driver.errors import ProtocolError
from scout_driver.line import BITS_PER_BYTE
from scout_driver.protocol.commands import NAK, Command, command_from_frame
from scout_driver.protocol.framing import Frame, FrameParser, encode_frame
from scout_driver.protocol.replies import STATE_DATA_MIN, STATE_REPLIES

BACKLOG_S = 0.5
"""Buffers along the line hold so much; bytes that would wait longer are lost."""
FIFO_BYTES = 16
"""Bytes come out of a UART in groups; waking up for each one would cost more than the emulation."""


class EmulatedLine:
    """Bytes in, time passing, bytes out."""

    def __init__(self, base: EmulatedBase, config: EmulatorConfig, faults: Faults) -> None:
        """Connect a base."""
        self.base, self._config, self._faults = base, config, faults
        self._byte_s = BITS_PER_BYTE / config.baud
        self._parser = FrameParser()
        self._arriving: deque[tuple[float, int]] = deque()
        self._leaving: deque[tuple[float, bytes]] = deque()
        self._in_free_s = self._out_free_s = self._last_byte_s = 0.0
        self._replug_s = 0.0
        self.commands: deque[tuple[float, Command]] = deque(maxlen=1000)
        """The last commands understood, with the time at which they were."""
        self.state_stamps: deque[int] = deque(maxlen=1000)
        """Board times (ms) of the states reported since somebody emptied this."""
        self.unplugs = 0
        """Times the line was pulled out."""

    def plugged(self, now_s: float) -> bool:
        """Whether the line is in its socket."""
        return now_s >= self._replug_s

    def unplug(self, now_s: float, duration_s: float) -> None:
        """Pull the line out; what is on it is gone."""
        self._replug_s = now_s + duration_s
        self._arriving.clear()
        self._leaving.clear()
        self._parser.clear()
        self.unplugs += 1

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that the computer begins to send at ``now_s``."""
        if not self.plugged(now_s) or self._in_free_s - now_s > BACKLOG_S:
            return
        when = max(now_s, self._in_free_s)
        for byte, held_s in self._faults.damage(data):
            when += self._on_line_s() + held_s
            self._arriving.append((when, byte))
        self._in_free_s = when

    def advance(self, now_s: float) -> None:
        """Let time pass: bytes arrive, commands are carried out, replies begin."""
        while self._arriving and self._arriving[0][0] <= now_s:
            when, byte = self._arriving.popleft()
            self._pass_time(when)
            before = self._parser.discarded
            frames = self._parser.line_silent() if when - self._last_byte_s > self._config.silence_s else []
            frames += self._parser.feed(bytes((byte,)))
            self._last_byte_s = when
            for frame in frames:
                self._understand(frame, when)
            if self._config.nak_bad_frames and self._parser.discarded > before:
                self._send(encode_frame(Frame(NAK)), when, 0.0)
        self._pass_time(now_s)

    def transmit(self, now_s: float) -> bytes:
        """Return the bytes that have reached the computer by ``now_s``."""
        out = b""
        while self._leaving and self._leaving[0][0] <= now_s:
            out += self._leaving.popleft()[1]
        return out

    def next_event_s(self) -> float | None:
        """Return when the next byte arrives at either end, None if none is on its way."""
        times = [queue[0][0] for queue in (self._arriving, self._leaving) if queue]
        return min(times, default=None)

    def _on_line_s(self) -> float:
        return 0.0 if self._config.exchange_s else self._byte_s

    def _pass_time(self, to_s: float) -> None:
        """Let the world go on; in lock-step only commands do that."""
        if self._config.exchange_s == 0.0:
            self.base.advance(to_s)
            waited = self.base.waited()
            if waited is not None:
                self._send(encode_frame(waited), to_s, 0.0)

    def _understand(self, frame: Frame, when: float) -> None:
        try:
            command = command_from_frame(frame)
        except ProtocolError:
            return
        if self._faults.unplugs():
            self.unplug(when, self._faults.config.unplugged_s)
            return
        fault = self._faults.for_reply()
        if fault is ReplyFault.DEAF:
            return
        if fault is ReplyFault.NAK:
            self._send(encode_frame(Frame(NAK)), when, 0.0)
            return
        self.commands.append((when, command))
        reply = self._carry_out(command)
        if reply is None or fault is ReplyFault.SILENT:
            return
        if command.kind in STATE_REPLIES:
            self.state_stamps.append(self.base.board_ms)
            if fault is ReplyFault.SHORT:
                reply = Frame(reply.kind, reply.data[:STATE_DATA_MIN])
        held_s = self._faults.held_back_s() if fault is ReplyFault.LATE else 0.0
        self._send(encode_frame(reply) * (2 if fault is ReplyFault.REPEATED else 1), when, held_s)

    def _carry_out(self, command: Command) -> Frame | None:
        """Return the reply; in lock-step the state is that of the end of the step that a motion began.

        Whatever is no motion takes effect as the reply is made, as it does outside lock-step.
        """
        base, step_s = self.base, self._config.exchange_s
        if step_s == 0.0:
            return base.handle(command)
        if command.kind not in MOTION:
            base.advance(base.now_s + step_s)
            base.carry_out(command)
        else:
            base.carry_out(command)
            base.advance(base.now_s + step_s)
        return base.reply(command.kind)

    def _send(self, data: bytes, when: float, held_s: float) -> None:
        """Put a reply on the line."""
        if self._out_free_s - when > BACKLOG_S:
            return
        pause_s = 0.0 if self._config.exchange_s else self._config.processing_s
        at_s = max(when + pause_s + held_s, self._out_free_s)
        group = bytearray()
        for byte, late_s in self._faults.damage(data):
            at_s += self._on_line_s() + late_s
            group.append(byte)
            if len(group) == FIFO_BYTES or late_s > 0.0:
                self._leaving.append((at_s, bytes(group)))
                group.clear()
        if group:
            self._leaving.append((at_s, bytes(group)))
        self._out_free_s = at_s
