"""Puts inputs from several topics back into the order of their stamps, one cycle at a time.

DDS keeps order within a topic, not between topics. A cycle (one clock message, usually odometry) is
ready once every other stream is known to be complete up to its stamp:

- an *implicit* stream is complete up to the stamp of its newest message (sonar, published every cycle);
- a *promised* stream is complete up to a stamp once as many messages have come as its source's
  NodeStatus for that stamp says it has published (events, edge-maps);
- with a hold-back time, for running free, a cycle is also ready once the clock is that much further.

A message that was refused at the door still counts as come: it is an empty one.

When the clock's stamps go back (a bag that loops, a simulator started again) its cycles begin anew. When the count of a
promised stream goes down its source was started again, which the next cycle tells.
"""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hslam_ros.stream import ImplicitStream, PromisedStream, Stream
from hslam_types.errors import MessageError

TIME = "time"
"""What the clock itself is called where it begins anew."""
_NEAR_NS = 1_000_000_000
"""How far ahead of the clock the stamp of a refused message is still believed."""


@dataclass(frozen=True, slots=True)
class Cycle:
    """All inputs of one cycle: the clock's item and each stream's items with stamps up to it, oldest first."""

    stamp_ns: int
    clock: Any
    inputs: dict[str, tuple[Any, ...]]
    skipped: bool = False
    """Whether the clock's message was refused: there is nothing to do but to answer; the inputs wait for the next."""
    anew: Mapping[str, str] = field(default_factory=dict)
    """What shows that a source was started again since the last cycle, by stream; by `TIME` stamps that went back."""
    complete_ns: Mapping[str, int] = field(default_factory=dict)
    """Stamp up to which no message of a stream is missing; less than the cycle's where it was not waited for."""


class StepOrder:
    """Collects messages as they come and hands out complete cycles in order of stamp."""

    def __init__(
        self,
        implicit: Sequence[str] = (),
        promised: Mapping[str, int] | None = None,
        hold_ns: int | None = None,
        *,
        take_up: bool = False,
    ) -> None:
        """Take the streams' names, of the promised ones also how many messages their sources keep for who comes late.

        ``hold_ns`` None: lock-step, wait for every stream however long it takes.  ``take_up``: what was said before
        the first cycle belongs to that one; otherwise it is left out, since this node has not lived through it.
        """
        self._promised = {name: PromisedStream(history) for name, history in (promised or {}).items()}
        self._streams: dict[str, Stream] = {**{name: ImplicitStream() for name in implicit}, **self._promised}
        self._clock: deque[tuple[int, Any, bool]] = deque()
        self._hold_ns, self._take_up = hold_ns, take_up
        self._now_ns = self._since_ns = -1
        self._anew: dict[str, str] = {}

    def tick(self, stamp_ns: int, item: Any = None) -> None:
        """Announce a cycle: the clock's message. Raises MessageError for one that repeats the last stamp."""
        if stamp_ns == self._now_ns:
            raise MessageError(f"header.stamp = {stamp_ns * 1e-9:.3f} s is that of the message before")
        if stamp_ns < self._now_ns:
            self._anew[TIME] = f"stamps went back from {self._now_ns * 1e-9:.2f} s to {stamp_ns * 1e-9:.2f} s"
            self._clock.clear()
            for entry in self._streams.values():
                entry.turn_back(stamp_ns + _NEAR_NS)
        if stamp_ns < self._now_ns or self._since_ns < 0:
            self._begin(stamp_ns)
        self._now_ns = stamp_ns
        self._clock.append((stamp_ns, item, False))

    def skip(self, stamp_ns: int | None) -> None:
        """Announce a cycle whose clock message was refused, if its stamp can be believed."""
        stamp_ns = self._believed(stamp_ns)
        if stamp_ns is not None and stamp_ns > self._now_ns:
            self._now_ns = stamp_ns
            self._clock.append((stamp_ns, None, True))

    def put(self, stream: str, stamp_ns: int, item: Any) -> None:
        """Add a message of a stream."""
        if stamp_ns >= self._since_ns:
            self._streams[stream].put(stamp_ns, item)
        self._streams[stream].count(stamp_ns)

    def miss(self, stream: str, stamp_ns: int | None) -> None:
        """Note that a message of a stream was refused."""
        self._streams[stream].count(self._believed(stamp_ns))

    def promise(self, stream: str, stamp_ns: int, total: int) -> None:
        """Note that the source has published ``total`` messages on the stream up to ``stamp_ns``."""
        again = self._promised[stream].promise(stamp_ns, total)
        if again:
            self._anew[stream] = again

    def ready(self) -> Iterator[Cycle]:
        """Yield, and forget, every cycle that is complete."""
        while self._clock:
            stamp_ns, item, skipped = self._clock[0]
            overdue = self._hold_ns is not None and self._clock[-1][0] - stamp_ns >= self._hold_ns
            if not overdue and any(entry.complete_ns < stamp_ns for entry in self._streams.values()):
                return
            self._clock.popleft()
            if skipped:
                yield Cycle(stamp_ns, None, {}, skipped=True)
                continue
            anew, self._anew = self._anew, {}
            inputs = {name: entry.take(stamp_ns) for name, entry in self._streams.items()}
            complete_ns = {name: entry.complete_ns for name, entry in self._streams.items()}
            yield Cycle(stamp_ns, item, inputs, anew=anew, complete_ns=complete_ns)

    def _begin(self, stamp_ns: int) -> None:
        """Note that the clock begins here, for the first time or anew; what was said before is left out."""
        if not self._take_up:
            self._since_ns = stamp_ns
            for entry in self._streams.values():
                entry.keep(first_ns=stamp_ns)

    def _believed(self, stamp_ns: int | None) -> int | None:
        """Return the stamp of a message that was refused, None if the rest of it can be no better than it."""
        near = stamp_ns is not None and (self._now_ns < 0 or stamp_ns <= self._now_ns + _NEAR_NS)
        return stamp_ns if near else None
