"""What a replay says in place of the nodes whose output it publishes: how much of it there was up to a cycle.

Nodes in lock-step wait for as many messages of a stream as its source's status promises. The recorded statuses count
from the recorded run's start and know nothing of topics left out; so a replay counts for itself, and a bag without
statuses replays too.
"""

from collections.abc import Collection, Mapping

COUNTED: Mapping[str, tuple[str, ...]] = {
    "sim": ("/landmarks",),
    "gvg": ("/gvg/events",),
    "ekf": ("/ekf/edge_maps", "/ekf/frame_links"),
}
"""Whose status counts which topics (each node's table in its package's README)."""


class Promises:
    """Counts what is replayed, by source."""

    def __init__(self, live: Collection[str]) -> None:
        """Speak for every source that is not ``live``."""
        self._counts = {source: 0 for source in COUNTED if source not in live}
        self._source = {topic: source for source in self._counts for topic in COUNTED[source]}

    @property
    def sources(self) -> tuple[str, ...]:
        """Who is spoken for."""
        return tuple(self._counts)

    @property
    def status_topics(self) -> frozenset[str]:
        """The recorded statuses that these take the place of."""
        return frozenset(f"/{source}/status" for source in self._counts)

    def count(self, topic: str) -> None:
        """Note that a message was published."""
        source = self._source.get(topic)
        if source is not None:
            self._counts[source] += 1

    def outputs(self, source: str) -> int:
        """Return how many counted messages of a source were published."""
        return self._counts[source]
