"""What is in a bag, and what is wrong with it."""

from pathlib import Path
from typing import NamedTuple

from hslam_bags.bag import Bag


class TopicSummary(NamedTuple):
    """One topic."""

    name: str
    type_name: str
    message_count: int
    latched: bool


class BagInfo(NamedTuple):
    """A bag at a glance; times in nanoseconds."""

    path: Path
    files: tuple[tuple[str, int], ...]
    """Name and size (bytes) of each."""
    span_ns: tuple[int, int] | None
    topics: tuple[TopicSummary, ...]
    custom: dict[str, str]
    problems: tuple[str, ...]

    @property
    def message_count(self) -> int:
        """Messages over all topics."""
        return sum(topic.message_count for topic in self.topics)

    @property
    def duration_s(self) -> float:
        """Seconds between the first and the last message."""
        return (self.span_ns[1] - self.span_ns[0]) * 1e-9 if self.span_ns else 0.0


def info(path: Path, *, thorough: bool = False) -> BagInfo:
    """Describe the bag at ``path``, damaged or not; BagError if it is none. ``thorough`` reads all to find damage."""
    with Bag(path, tolerant=True) as bag:
        if thorough:
            for _ in bag.messages():
                pass
            bag.check()
        counts = bag.counts
        topics = tuple(
            TopicSummary(
                name,
                topic.type_name,
                counts.get(name, 0),
                any(offer.durability == "transient_local" for offer in topic.offers),
            )
            for name, topic in sorted(bag.topics.items())
        )
        folder = path if path.is_dir() else path.parent
        files = tuple(
            (file.name, file.stat().st_size)
            for file in sorted(folder.iterdir())
            if file == path or (path.is_dir() and Path(file.stem).stem in {Path(name).stem for name in bag.files})
        )
        problems = tuple(str(problem) for problem in bag.problems)
        return BagInfo(path, files, bag.span_ns, topics, dict(bag.custom), problems)
