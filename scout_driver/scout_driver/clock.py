"""The driver's time: seconds that only go forward, by the wall, scaled, or moved by an emulated line."""

import time
from typing import Protocol

from scout_driver.errors import ProtocolError


class Clock(Protocol):
    """Something that tells the robot's time."""

    def now(self) -> float:
        """Return seconds since an arbitrary start."""
        ...


class WallClock:
    """The computer's monotonic clock; ``factor`` above 1 only with an emulator that runs as much faster."""

    def __init__(self, factor: float = 1.0) -> None:
        """Count from now on, ``factor`` robot seconds a wall second."""
        self.factor = factor
        self._start = time.monotonic()

    def now(self) -> float:
        """Return robot seconds since the start."""
        return (time.monotonic() - self._start) * self.factor


class Dating(Protocol):
    """Something that tells when a state was measured."""

    def stamp(self, board_ms: int | None, received_s: float, line_s: float) -> float:
        """Return the moment of measurement on the driver's clock (s); raises ProtocolError if it cannot be told."""
        ...


class BoardTime:
    """The base's own counter as the only clock: for lock-step, where the wall must not matter at all."""

    def __init__(self) -> None:
        """Stand at zero until the first state."""
        self._now_s = 0.0

    def now(self) -> float:
        """Return the board time of the last state (s)."""
        return self._now_s

    def stamp(self, board_ms: int | None, received_s: float, line_s: float) -> float:
        """Take the board time of a state as the time it is now; what the computer's clock says is of no account."""
        del received_s, line_s
        if board_ms is None:
            raise ProtocolError("a state without board time cannot be dated in lock-step")
        self._now_s = board_ms * 1e-3
        return self._now_s
