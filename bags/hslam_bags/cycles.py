"""A bag's messages in the order and the portions in which a replay publishes them."""

import heapq
from collections.abc import Callable, Collection, Iterable, Iterator
from typing import NamedTuple

from hslam_bags.bag import Bag
from hslam_bags.errors import BagError
from hslam_bags.recording_clock import NEAR_NS, leading_stamp_ns
from hslam_bags.stored import StoredMessage
from hslam_bags.topic_choice import TopicChoice

WINDOW_NS = 2 * 10**9
"""How much later than its stamp a message may have been recorded and still be put back in its place."""


class Portion(NamedTuple):
    """Messages to be published together at one time (ns); ``complete``: they end a cycle, which nodes answer."""

    time_ns: int
    messages: tuple[StoredMessage, ...]
    complete: bool


def stamp_of(message: StoredMessage) -> int:
    """Return a stamped message's own time (ns), or its log time where the stamp is of another time."""
    stamp_ns = leading_stamp_ns(message.raw)
    return stamp_ns if stamp_ns >= 0 and abs(stamp_ns - message.log_ns) <= NEAR_NS else message.log_ns


def in_stamp_order(
    messages: Iterable[StoredMessage], time_of: Callable[[StoredMessage], int]
) -> Iterator[tuple[int, StoredMessage]]:
    """Yield (time, message) in order of ``time_of``, given messages in order of log time; equal times keep their order.

    A bag recorded on a real robot has a cycle's events a little after the next cycle's odometry; nodes in lock-step
    must get them before it.
    """
    held: list[tuple[int, int, StoredMessage]] = []
    for order, message in enumerate(messages):
        heapq.heappush(held, (time_of(message), order, message))
        while held[0][0] < message.log_ns - WINDOW_NS:
            time_ns, _, first = heapq.heappop(held)
            yield time_ns, first
    while held:
        time_ns, _, first = heapq.heappop(held)
        yield time_ns, first


def in_portions(messages: Iterable[tuple[int, StoredMessage]], cycle_topic: str | None) -> Iterator[Portion]:
    """Group messages, given in order of time, by time; with a ``cycle_topic``, by the times of its messages.

    A cycle's portion holds everything since the cycle before. What follows the last cycle is a portion that ends none.
    """
    time_ns = 0
    held: list[StoredMessage] = []
    complete = False
    for message_ns, message in messages:
        if held and message_ns != time_ns and (complete or cycle_topic is None):
            yield Portion(time_ns, tuple(held), complete)
            held, complete = [], False
        time_ns = message_ns
        held.append(message)
        complete = complete or message.topic == cycle_topic
    if held:
        yield Portion(time_ns, tuple(held), complete)


def replayed(
    bag: Bag, choice: TopicChoice, start_ns: int, stamped: Collection[str], cycle_topic: str | None
) -> Iterator[Portion]:
    """Yield what a replay publishes: by log time, or, with a ``cycle_topic``, by cycles in order of stamps.

    ``stamped`` are the topics whose messages begin with a header. BagError if there are no cycles to go by.
    """
    messages = bag.messages(choice, start_ns)
    if cycle_topic is None:
        return in_portions(((message.log_ns, message) for message in messages), None)
    if not bag.counts.get(cycle_topic) or cycle_topic not in choice:
        raise BagError(bag.path, f"topic {cycle_topic}", "is not replayed, though it gives lock-step its cycles")
    ordered = in_stamp_order(messages, lambda entry: stamp_of(entry) if entry.topic in stamped else entry.log_ns)
    return in_portions(ordered, cycle_topic)
