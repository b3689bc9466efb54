"""What a bag's storage offers, whatever its format."""

import heapq
from collections.abc import Callable, Collection, Iterable, Iterator
from typing import NamedTuple, Protocol

from hslam_bags.errors import BagError
from hslam_bags.qos import OfferedQos

Iteration = Callable[[], Iterator["StoredMessage"]]

Complaint = Callable[[BagError], None]
"""Told of damage that can be stepped over; it raises the error where nothing may be missing."""


class StoredMessage(NamedTuple):
    """A recorded message: its CDR bytes, and when it was received and published (ns)."""

    topic: str
    type_name: str
    raw: bytes
    log_ns: int
    publish_ns: int


class StoredTopic(NamedTuple):
    """A recorded topic; ``definition`` is the type's schema as stored, empty where a bag has none."""

    name: str
    type_name: str
    offers: tuple[OfferedQos, ...]
    type_hash: str
    encoding: str
    definition: str


class Storage(Protocol):
    """One file of a bag."""

    @property
    def topics(self) -> tuple[StoredTopic, ...]:
        """The topics, in the order they were added."""

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """First and last log time, None if there is no message."""

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic."""

    def messages(self, topics: Collection[str], start_ns: int, end_ns: int) -> Iterator[StoredMessage]:
        """Yield the messages of ``topics`` with start <= log time < end, in order of log time."""

    def check(self) -> None:
        """Complain of damage that reading the messages does not meet."""

    def close(self) -> None:
        """Give back what the file holds of the system."""


def in_time_order(pieces: Iterable[tuple[int, Iteration]]) -> Iterator[StoredMessage]:
    """Merge pieces, each in order of log time and none before the time (ns) given with it.

    A piece is opened only when its time has come, so that of a long bag only what overlaps is in memory. Messages of
    one time come in the order of the pieces.
    """
    waiting = sorted(enumerate(pieces), key=lambda entry: (entry[1][0], entry[0]), reverse=True)
    heads: list[tuple[int, int, StoredMessage, Iterator[StoredMessage]]] = []
    while waiting or heads:
        while waiting and (not heads or waiting[-1][1][0] <= heads[0][0]):
            order, (_, iterate) = waiting.pop()
            _push(heads, order, iterate())
        if heads:
            _, order, message, rest = heapq.heappop(heads)
            yield message
            _push(heads, order, rest)


def _push(
    heads: list[tuple[int, int, StoredMessage, Iterator[StoredMessage]]], order: int, rest: Iterator[StoredMessage]
) -> None:
    """Put a piece's next message among the heads, if there is one."""
    message = next(rest, None)
    if message is not None:
        heapq.heappush(heads, (message.log_ns, order, message, rest))
