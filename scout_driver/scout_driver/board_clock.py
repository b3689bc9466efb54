"""The base's millisecond counter set against the computer's clock.

Replies come late by the line, the adapter and the computer, never early: the least delay of the last
few is the truest offset. The second least is used, so that one damaged counter does no harm.
"""

from collections import deque

WINDOW = 50
"""States looked back upon: 3 s of the default cycle, in which two quartz clocks drift by less than 1 ms."""
JUMP_S = 1.0
"""An offset this far off means a damaged counter, or a base that was switched off and on."""
CONFIRMATIONS = 3
"""So many of these in a row that agree with each other: the counter began anew."""


class BoardClock:
    """Turns (board time, time of arrival) into the moment of measurement, on the computer's clock."""

    def __init__(self) -> None:
        """Start without an offset."""
        self._offsets: deque[float] = deque(maxlen=WINDOW)
        self._suspects: list[float] = []
        self.restarts = 0
        """Times the base's counter began anew."""

    def stamp(self, board_ms: int | None, received_s: float, line_s: float) -> float:
        """Return when a state was measured, given when it had come in and how long it was on the line (s).

        Falls back to the time of arrival less ``line_s`` while the counter is missing or not believed.
        """
        latest = received_s - line_s
        if board_ms is None:
            return latest
        offset = latest - board_ms * 1e-3
        if self._offsets and abs(offset - self._offset()) > JUMP_S and not self._began_anew(offset):
            return latest
        self._suspects.clear()
        self._offsets.append(offset)
        return board_ms * 1e-3 + self._offset()

    def _offset(self) -> float:
        ordered = sorted(self._offsets)
        return ordered[min(1, len(ordered) - 1)]

    def _began_anew(self, offset: float) -> bool:
        """Tell whether enough disbelieved counters agree with each other; if so, start over with the last."""
        if self._suspects and abs(offset - self._suspects[-1]) > JUMP_S:
            self._suspects.clear()
        self._suspects.append(offset)
        if len(self._suspects) < CONFIRMATIONS:
            return False
        self._offsets.clear()
        self.restarts += 1
        return True
