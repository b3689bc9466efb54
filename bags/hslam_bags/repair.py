"""Copying bags: what a damaged one still holds, or a part of a whole one."""

import math
import shutil
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from hslam_bags.bag import FOREVER_NS, Bag
from hslam_bags.definitions import Definition, DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.qos import OfferedQos
from hslam_bags.recorder import LATEST_NS, Recorder, RecorderConfig
from hslam_bags.stored import StoredMessage, StoredTopic
from hslam_bags.topic_choice import TopicChoice


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
    readable, ``target`` is not empty or the disk is full; then there is no new bag.
    """
    target = target or path.with_name(f"{path.name.split('.')[0]}_repaired")
    with Bag(path, tolerant=True) as bag:
        if not bag.topics:
            first = bag.problems[0] if bag.problems else BagError(path, "", "holds no topic")
            raise BagError(first.path, first.place, f"{first.problem}; nothing is readable")
        kept = copy(bag, target, config=config)
        bag.check()
        return Repair(target, kept, tuple(str(problem) for problem in bag.problems))


def copy(
    bag: Bag,
    target: Path,
    choice: TopicChoice | None = None,
    span_s: tuple[float, float] = (0.0, math.inf),
    config: RecorderConfig | None = None,
) -> int:
    """Copy the chosen topics' messages to a new bag at ``target`` and return how many there were.

    ``span_s`` is the part to copy, in seconds from the first message. What a bag cannot hold (a type without
    definition, a time before 0) is a problem of ``bag``, left out if that is tolerant. Raises BagError as a recorder
    does; then ``target`` is as it was.
    """
    first_ns = (bag.span_ns or (0, 0))[0]
    start_ns = first_ns + round(span_s[0] * 1e9)
    end_ns = FOREVER_NS if math.isinf(span_s[1]) else first_ns + round(span_s[1] * 1e9)
    topics = {name: topic for name, topic in bag.topics.items() if choice is None or name in choice}
    definitions = StoredDefinitions(topics)
    topics = {name: topic for name, topic in topics.items() if _is_defined(topic, definitions, bag)}
    if not topics:
        raise BagError(bag.path, "", "holds no topic that can be copied")
    was_there = target.exists()
    recorder = Recorder(target, config, definitions=definitions, custom=bag.custom)
    try:
        with recorder:
            for topic in topics.values():
                recorder.add_topic(topic.name, topic.type_name, topic.offers or (OfferedQos(),))
            _copy_messages(bag, recorder, bag.messages(topics, start_ns, end_ns))
    except BaseException as error:
        shutil.rmtree(target, ignore_errors=True)
        if was_there:
            target.mkdir()
        if recorder.cause is not None:
            raise recorder.cause from error
        raise
    return recorder.message_count


def _is_defined(topic: StoredTopic, definitions: DefinitionSource, bag: Bag) -> bool:
    """Whether a topic's type is known; if not, the bag is told."""
    try:
        definitions.find(topic.type_name)
    except LookupError as error:
        bag.complain(BagError(bag.path, f"topic {topic.name}", f"is left out: {error}"))
        return False
    return True


def _copy_messages(bag: Bag, recorder: Recorder, messages: Iterable[StoredMessage]) -> None:
    """Record messages; the bag is told of those whose times no bag can hold."""
    untimely: Counter[str] = Counter()
    for message in messages:
        if 0 <= message.log_ns <= LATEST_NS and 0 <= message.publish_ns <= LATEST_NS:
            recorder.write(message.topic, message.type_name, message.raw, message.log_ns, message.publish_ns)
        else:
            untimely[message.topic] += 1
    for topic, count in untimely.items():
        bag.complain(BagError(bag.path, f"topic {topic}", f"{count} messages have times past the year 2262"))
