"""Driver and emulated base in one process on a clock that jumps from event to event: hours in seconds, exactly."""

from collections.abc import Callable

from scout_driver.emulator.line import EmulatedLine
from scout_driver.errors import LineLostError


class VirtualClock:
    """A clock that goes only where it is put."""

    def __init__(self) -> None:
        """Begin at zero."""
        self._now_s = 0.0

    def now(self) -> float:
        """Return the time (s)."""
        return self._now_s

    def go_to(self, when_s: float) -> None:
        """Move on to ``when_s``; never back."""
        self._now_s = max(self._now_s, when_s)


class LoopbackTransport:
    """A transport whose other end is an emulated line; waiting moves the clock."""

    def __init__(self, line: EmulatedLine, clock: VirtualClock) -> None:
        """Plug in; raises LineLostError while the line is pulled out."""
        self._line, self._clock = line, clock
        self._plugged_times = line.unplugs
        self._check()

    def write(self, data: bytes) -> None:
        """Send ``data``."""
        self._check()
        self._line.receive(data, self._clock.now())

    def read(self, timeout_s: float, settle_s: float = 0.0) -> bytes:
        """Wait for bytes, up to ``timeout_s``, after ``settle_s`` in any case."""
        self._clock.go_to(self._clock.now() + settle_s)
        self._line.advance(self._clock.now())
        deadline_s = self._clock.now() + timeout_s
        while True:
            self._check()
            event_s = self._line.next_event_s()
            self._clock.go_to(deadline_s if event_s is None else min(event_s, deadline_s))
            self._line.advance(self._clock.now())
            data = self._line.transmit(self._clock.now())
            if data or self._clock.now() >= deadline_s:
                return data

    def close(self) -> None:
        """Nothing to let go."""

    def _check(self) -> None:
        if self._line.unplugs != self._plugged_times or not self._line.plugged(self._clock.now()):
            raise LineLostError("the emulated line is unplugged")


def wait_until(line: EmulatedLine, clock: VirtualClock, when_s: float) -> None:
    """Let time pass with nobody listening."""
    clock.go_to(when_s)
    line.advance(clock.now())


def opener(line: EmulatedLine, clock: VirtualClock) -> Callable[[], LoopbackTransport]:
    """Return what a driver opens its line with."""
    return lambda: LoopbackTransport(line, clock)
