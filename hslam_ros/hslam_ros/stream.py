"""One input of a node as it waits for its cycle: what has come of it, and up to which stamp that is all there is."""

from collections import deque
from typing import Any


class Stream:
    """The messages that no cycle has taken yet; up to ``complete_ns`` none is missing."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.complete_ns = -1
        self._items: deque[tuple[int, Any]] = deque()

    def put(self, stamp_ns: int, item: Any) -> None:
        """Keep a message."""
        self._items.append((stamp_ns, item))

    def count(self, stamp_ns: int | None) -> None:
        """Note that a message has come, whatever becomes of it; None: at a time that is not to be believed."""
        raise NotImplementedError

    def take(self, stamp_ns: int) -> tuple[Any, ...]:
        """Remove and return the messages stamped up to ``stamp_ns``, as they came."""
        taken = tuple(item for stamp, item in self._items if stamp <= stamp_ns)
        if taken:
            self.keep(stamp_ns + 1)
        return taken

    def keep(self, first_ns: int = -1, last_ns: int | None = None) -> None:
        """Drop every message but those stamped from ``first_ns`` to ``last_ns``."""
        kept = (entry for entry in self._items if entry[0] >= first_ns and (last_ns is None or entry[0] <= last_ns))
        self._items = deque(kept)

    def turn_back(self, last_ns: int) -> None:
        """Begin anew since time has gone back: what is stamped later than ``last_ns`` was said before that."""
        self.keep(last_ns=last_ns)


class ImplicitStream(Stream):
    """Complete up to its newest message."""

    def count(self, stamp_ns: int | None) -> None:
        """Note that a message has come."""
        if stamp_ns is not None:
            self.complete_ns = stamp_ns

    def turn_back(self, last_ns: int) -> None:
        """Begin anew; only what is left tells how far the stream has come."""
        super().turn_back(last_ns)
        self.complete_ns = self._items[-1][0] if self._items else -1


class PromisedStream(Stream):
    """Complete up to a stamp once as many messages have come as their source says it has published by then."""

    def __init__(self, history: int) -> None:
        """``history``: how many messages the source keeps for a listener that comes late."""
        super().__init__()
        self._history = history
        self._received = 0
        self._counted_from_ns = -1
        self._promises: deque[tuple[int, int]] = deque()
        self._promised = (-1, 0)

    def count(self, stamp_ns: int | None) -> None:
        """Note that a message has come."""
        if stamp_ns is None or stamp_ns >= self._counted_from_ns:
            self._received += 1
            self._settle()

    def promise(self, stamp_ns: int, total: int) -> str:
        """Note that the source has said ``total`` messages by a stamp; return in words if it was started again.

        That shows in a count that goes down.  All that such a source has said itself is stamped up to its first
        promise, which comes with its first cycle.  Where its time alone goes back, it counts on.
        """
        before_ns, before = self._promised
        self._promised = stamp_ns, total
        if total < before or stamp_ns < before_ns:
            self._promises.clear()
            self.complete_ns = -1
        if total < before:
            self.keep(last_ns=stamp_ns)
            self._received, self._counted_from_ns = len(self._items), -1
        elif before_ns < 0 and total > self._history:  # this listener is late, and will never have them all
            self.keep(first_ns=stamp_ns + 1)
            self._received, self._counted_from_ns = total + len(self._items), stamp_ns + 1
        self._promises.append((stamp_ns, total))
        self._settle()
        return f"it has said {total} by {stamp_ns * 1e-9:.2f} s, after {before} before" if total < before else ""

    def _settle(self) -> None:
        """Redeem the promises that the messages received so far fulfil."""
        while self._promises and self._promises[0][1] <= self._received:
            self.complete_ns = max(self.complete_ns, self._promises.popleft()[0])
