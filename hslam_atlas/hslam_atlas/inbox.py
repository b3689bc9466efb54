"""Where what the GVG level announces meets what the EKF level makes of it, by number, however late either comes.

An arrival that ends a traversal has an edge-map, a departure that follows such an arrival a link.  In lock-step both
come in one cycle.  Running free either may come later than a cycle is held back: events then wait here, in their order,
until what belongs to them has come, or the EKF level has said that it has done with them and no more is on its way.
"""

from collections import deque
from dataclasses import dataclass

from hslam_types.answer import Answer
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent

Output = EdgeMap | FrameLink
Key = tuple[EventKind, int]
"""What an output belongs to: the kind and the number of an event."""


@dataclass(frozen=True, slots=True, eq=False)
class Met:
    """Events that need wait no longer, oldest first, with what belongs to them."""

    events: tuple[GvgEvent, ...] = ()
    edge_maps: tuple[EdgeMap, ...] = ()
    links: tuple[FrameLink, ...] = ()


class Inbox:
    """Keeps events, edge-maps and links until they have met."""

    def __init__(self, *, waits: bool) -> None:
        """``waits``: False in lock-step, where nothing of a cycle is still on its way."""
        self._waits = waits
        self.late = 0
        """How many edge-maps and links did not come in the same cycle as their events."""
        self.latest_s = 0.0
        """By how much at most."""
        self._news: list[str] = []
        self.clear()

    def clear(self) -> None:
        """Begin anew where time or the GVG level has: the numbers of before mean nothing any more."""
        self._events: deque[tuple[GvgEvent, int]] = deque()
        self._outputs: dict[Key, tuple[Output, int]] = {}
        self._said: deque[tuple[int, int]] = deque()
        self._done_ns, self._done = -1, 0
        self._ekf_since_ns = -1
        self._before: GvgEvent | None = None
        self._mapped = False
        self._told: GvgEvent | None = None

    def hear(self, answer: Answer) -> None:
        """Take the EKF level's answer to a cycle; one whose numbers go down was started again, and owes nothing."""
        newest = self._said[-1][1] if self._said else self._done
        if answer.next_event < newest:
            self._ekf_since_ns = answer.stamp_ns
        self._said.append((answer.stamp_ns, answer.next_event))

    def take(self, stamp_ns: int, events: tuple[GvgEvent, ...], outputs: tuple[Output, ...], complete_ns: int) -> Met:
        """Take what a cycle brought; return the events that need wait no longer, with what belongs to them.

        ``complete_ns``: the stamp up to which all has come that the EKF level has said; of that, what is stamped later
        than the cycle belongs to a later one.
        """
        self._events.extend((event, stamp_ns) for event in events)
        for output in outputs:
            self._keep(output, stamp_ns)
        while self._said and self._said[0][0] <= min(stamp_ns, complete_ns):
            self._done_ns, self._done = self._said.popleft()
        met: list[GvgEvent] = []
        belonging: list[Output] = []
        while self._events and (not self._waits or self._is_whole(self._events[0][0])):
            event, since_ns = self._events.popleft()
            met.append(event)
            belonging += self._release(event, since_ns)
        self._tell_of_waiting()
        maps = tuple(output for output in belonging if isinstance(output, EdgeMap))
        links = tuple(output for output in belonging if isinstance(output, FrameLink))
        return Met(tuple(met), maps, links)

    def awaited(self, stamp_ns: int) -> str:
        """Return in words what is waited for, and since when; empty where nothing is."""
        if not self._events:
            return ""
        event, since_ns = self._events[0]
        return f"{_output_of(event)} has been awaited for {(stamp_ns - since_ns) * 1e-9:.1f} s"

    def news(self) -> list[str]:
        """Return what is to be told since the last time: what is awaited, what came late, what came too late."""
        news, self._news = self._news, []
        return news

    def _keep(self, output: Output, stamp_ns: int) -> None:
        key = (
            (EventKind.ARRIVAL, output.arrival)
            if isinstance(output, EdgeMap)
            else (EventKind.DEPARTURE, output.departure)
        )
        if self._before is not None and key[1] <= self._before.sequence:
            self._news.append(f"what belongs to {key[0].name.lower()} {key[1]} came too late, and is left out")
        else:
            self._outputs[key] = output, stamp_ns

    def _is_whole(self, event: GvgEvent) -> bool:
        """Whether all has come that belongs to an event, or no more of it will."""
        traced = self._before is not None and self._before.kind is EventKind.DEPARTURE
        expected = traced if event.kind is EventKind.ARRIVAL else event.kind is EventKind.DEPARTURE and self._mapped
        if not expected:
            return True
        # The outputs of a topic come in order.
        come = max((number for kind, number in self._outputs if kind is event.kind), default=-1) >= event.sequence
        done = self._done > event.sequence and self._done_ns >= event.stamp_ns
        return come or done or event.stamp_ns < self._ekf_since_ns

    def _release(self, event: GvgEvent, since_ns: int) -> list[Output]:
        """Let an event go; return what belongs to it, at most one output."""
        output, come_ns = self._outputs.pop((event.kind, event.sequence), (None, since_ns))
        if come_ns != since_ns:
            late_s = abs(come_ns - since_ns) * 1e-9
            self.late, self.latest_s = self.late + 1, max(self.latest_s, late_s)
            self._news.append(
                f"{_output_of(event)} came {late_s:.1f} s {'after' if come_ns > since_ns else 'before'} it"
            )
        self._before, self._mapped = event, event.kind is EventKind.ARRIVAL and output is not None
        return [] if output is None else [output]

    def _tell_of_waiting(self) -> None:
        """Note once for every event that it waits."""
        if self._events and self._events[0][0] is not self._told:
            self._told = self._events[0][0]
            self._news.append(f"{_output_of(self._told)} is late, and waited for")


def _output_of(event: GvgEvent) -> str:
    """Return what belongs to an event, in words."""
    what = "edge-map" if event.kind is EventKind.ARRIVAL else "link"
    return f"the {what} of {event.kind.name.lower()} {event.sequence}"
