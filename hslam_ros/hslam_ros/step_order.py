"""Puts inputs from several topics back into the order of their stamps, one cycle at a time.

DDS keeps order within a topic, not between topics. A cycle (one clock message, usually odometry) is
ready once every other stream is known to be complete up to its stamp:

- an *implicit* stream is complete up to the stamp of its newest message (sonar, published every cycle);
- a *promised* stream is complete up to a stamp once as many messages have come as its source's
  NodeStatus for that stamp says it has published (events, edge-maps);
- with a hold-back time, for running free, a cycle is also ready once the clock is that much further.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class Cycle:
    """All inputs of one cycle: the clock's item and each stream's items with stamps up to it, oldest first."""

    stamp_ns: int
    clock: Any
    inputs: dict[str, tuple[Any, ...]]


@dataclass(slots=True)
class _Stream:
    implicit: bool
    items: deque[tuple[int, Any]] = field(default_factory=deque)
    received: int = 0
    complete_ns: int = -1
    promises: deque[tuple[int, int]] = field(default_factory=deque)

    def settle(self) -> None:
        """Redeem the promises that the messages received so far fulfil."""
        while self.promises and self.promises[0][1] <= self.received:
            self.complete_ns = max(self.complete_ns, self.promises.popleft()[0])

    def take(self, stamp_ns: int) -> tuple[Any, ...]:
        """Remove and return the items stamped up to ``stamp_ns``."""
        taken = []
        while self.items and self.items[0][0] <= stamp_ns:
            taken.append(self.items.popleft()[1])
        return tuple(taken)


class StepOrder:
    """Collects messages as they come and hands out complete cycles in order of stamp."""

    def __init__(self, implicit: Sequence[str] = (), promised: Sequence[str] = (), hold_ns: int | None = None) -> None:
        """``hold_ns`` None: lock-step, wait for every stream however long it takes."""
        self._streams = {name: _Stream(implicit=True) for name in implicit}
        self._streams.update({name: _Stream(implicit=False) for name in promised})
        self._clock: deque[tuple[int, Any]] = deque()
        self._hold_ns = hold_ns

    def tick(self, stamp_ns: int, item: Any = None) -> None:
        """Announce a cycle: the clock's message."""
        self._clock.append((stamp_ns, item))

    def put(self, stream: str, stamp_ns: int, item: Any) -> None:
        """Add a message of a stream."""
        entry = self._streams[stream]
        entry.items.append((stamp_ns, item))
        entry.received += 1
        if entry.implicit:
            entry.complete_ns = max(entry.complete_ns, stamp_ns)
        else:
            entry.settle()

    def promise(self, stream: str, stamp_ns: int, total: int) -> None:
        """Note that the source has published ``total`` messages on the stream up to ``stamp_ns``."""
        entry = self._streams[stream]
        entry.promises.append((stamp_ns, total))
        entry.settle()

    def ready(self) -> Iterator[Cycle]:
        """Yield, and forget, every cycle that is complete."""
        while self._clock:
            stamp_ns, item = self._clock[0]
            overdue = self._hold_ns is not None and self._clock[-1][0] - stamp_ns >= self._hold_ns
            if not overdue and any(entry.complete_ns < stamp_ns for entry in self._streams.values()):
                return
            self._clock.popleft()
            yield Cycle(stamp_ns, item, {name: entry.take(stamp_ns) for name, entry in self._streams.items()})
