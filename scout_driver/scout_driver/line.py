"""One exchange with the base: a command out, its state back, and a clean line whatever happens between.

The line is half duplex and numbers nothing, so a late reply would pass for the answer to the next
command, and so would every one after it. Hence nothing is sent before the line has been drained, and
after a failure not before it has been silent.
"""

from dataclasses import dataclass

from scout_driver.clock import Clock
from scout_driver.config import DriverConfig
from scout_driver.errors import ProtocolError
from scout_driver.protocol.commands import NAK, Command, command_to_frame
from scout_driver.protocol.framing import OVERHEAD, Frame, FrameParser, encode_frame
from scout_driver.protocol.replies import State, state_from_frame
from scout_driver.transport import Transport

BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""
REPLY_BYTES = 48
"""Length of a whole state reply."""
GAP_MAX_S = 0.1
"""A pause this long is silence, however long replies may pause."""
QUIET_MAX_S = 0.3
"""A line that babbles longer than this is drained and used all the same."""


@dataclass(slots=True)
class LineCounts:
    """What has happened on the line so far."""

    exchanges: int = 0
    answered: int = 0
    silent: int = 0
    """No reply at all."""
    broken: int = 0
    """A reply began but no whole one came."""
    refused: int = 0
    """NAK."""
    unexpected: int = 0
    """Whole replies of another type, or without a state (late ones, for instance)."""
    bytes_discarded: int = 0


@dataclass(frozen=True, slots=True)
class Answer:
    """A state with when it had come in (robot seconds) and how long it was on the line (s)."""

    state: State
    received_s: float
    line_s: float


class Line:
    """Carries out exchanges over an open transport."""

    def __init__(self, transport: Transport, config: DriverConfig, clock: Clock, counts: LineCounts) -> None:
        """Take over an open transport; ``counts`` is added to."""
        self._transport, self._config, self._clock = transport, config, clock
        self._parser = FrameParser()
        self._suspicious = True
        self._counts = counts

    def request(self, command: Command) -> Answer | None:
        """Send ``command`` and return its answer, None if no good one comes; raises LineLostError."""
        discarded = self._parser.discarded
        self._make_clean()
        self._counts.exchanges += 1
        self._transport.write(encode_frame(command_to_frame(command)))
        answer = self._await(command)
        self._counts.bytes_discarded += self._parser.discarded - discarded
        self._suspicious = answer is None
        if answer is not None:
            self._counts.answered += 1
        return answer

    def close(self) -> None:
        """Let the transport go."""
        self._transport.close()

    def _make_clean(self) -> None:
        """Throw away what lies on the line; after a failure wait until nothing more comes."""
        self._parser.clear()
        until_s = self._clock.now() + (QUIET_MAX_S if self._suspicious else 0.0)
        gap_s = min(self._config.gap_timeout_s, GAP_MAX_S) if self._suspicious else 0.0
        while self._transport.read(gap_s) and self._clock.now() < until_s:
            continue

    def _await(self, command: Command) -> Answer | None:
        deadline_s = self._clock.now() + self._config.reply_timeout_s
        byte_s = BITS_PER_BYTE / self._config.baud
        started = 0
        while True:
            wait_s = self._config.gap_timeout_s if started else deadline_s - self._clock.now()
            settle_s = max(0, REPLY_BYTES - started) * byte_s if started else 0.0
            data = self._transport.read(max(0.0, wait_s), settle_s)
            frames = self._parser.feed(data) if data else self._parser.line_silent()
            for frame in frames:
                if frame.kind == NAK:
                    self._counts.refused += 1
                    return None
                if (answer := self._answer(frame, command)) is not None:
                    return answer
            if not data:
                self._counts.broken += started > 0
                self._counts.silent += started == 0
                return None
            started += len(data)
            if self._clock.now() > deadline_s + QUIET_MAX_S:
                self._counts.broken += 1
                return None

    def _answer(self, frame: Frame, command: Command) -> Answer | None:
        """Return the answer in ``frame`` if it is one to ``command``."""
        if frame.kind != command.kind:
            self._counts.unexpected += 1
            return None
        try:
            state = state_from_frame(frame)
        except ProtocolError:
            self._counts.unexpected += 1
            return None
        size = len(frame.data) + 2 + OVERHEAD
        return Answer(state, self._clock.now(), size * BITS_PER_BYTE / self._config.baud)
