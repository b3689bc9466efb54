"""Making a whole bag of what a damaged one still holds."""

from pathlib import Path
from typing import NamedTuple

from hslam_bags.bag import Bag
from hslam_bags.definitions import Definition, DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.qos import OfferedQos
from hslam_bags.recorder import Recorder, RecorderConfig
from hslam_bags.stored import StoredTopic


class Repair(NamedTuple):
    """What came of it."""

    target: Path
    kept: int
    """Messages in the new bag."""
    problems: tuple[str, ...]
    """What was wrong with the old one, a line each."""


class StoredDefinitions(DefinitionSource):
    """Definitions as a bag stores them; installed ones where it has none."""

    def __init__(self, topics: dict[str, StoredTopic]) -> None:
        """Take the definitions of ``topics``."""
        super().__init__()
        self._stored = {topic.type_name: topic for topic in topics.values() if topic.definition}

    def find(self, type_name: str) -> Definition:
        """Return a type's definition; LookupError if neither the bag nor the machine has it."""
        topic = self._stored.get(type_name)
        if topic is None:
            return super().find(type_name)
        return Definition(type_name, topic.encoding, topic.definition, topic.type_hash, stamped=False)


def repair(path: Path, target: Path | None = None, config: RecorderConfig | None = None) -> Repair:
    """Copy everything readable of the bag at ``path`` into a new one; the old one is left as it is.

    ``target`` is the new bag's folder, by default the old name with "_repaired". Raises BagError if nothing is
    readable, ``target`` is not empty or the disk is full.
    """
    target = target or path.with_name(f"{path.name.split('.')[0]}_repaired")
    with Bag(path, tolerant=True) as bag:
        topics = bag.topics
        if not topics:
            first = bag.problems[0] if bag.problems else BagError(path, "", "holds no topic")
            raise BagError(first.path, first.place, f"{first.problem}; nothing is readable")
        kept = 0
        with Recorder(target, config, definitions=StoredDefinitions(topics), custom=bag.custom) as recorder:
            for topic in topics.values():
                recorder.add_topic(topic.name, topic.type_name, topic.offers or (OfferedQos(),))
            for message in bag.messages():
                recorder.write(message.topic, message.type_name, message.raw, message.log_ns, message.publish_ns)
                kept += 1
        return Repair(target, kept, tuple(str(problem) for problem in bag.problems))
