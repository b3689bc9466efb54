"""The publishers of a replay: raw bytes, with the QoS that was recorded."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message

from hslam_bags.definitions import DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.grown_types import ROOM, has_grown
from hslam_bags.message_types import message_class
from hslam_bags.ros_qos import profile_from_offers
from hslam_bags.stored import StoredMessage, StoredTopic
from hslam_ros.stamps import NS_PER_S

_HEADER = "std_msgs/Header"


class ReplayTopics:
    """One publisher a topic, made before the first message so that subscribers find it in time."""

    def __init__(self, node: Node, path: Path, topics: Mapping[str, StoredTopic], *, keep_for_late: bool) -> None:
        """Publish ``topics`` of the bag at ``path``; ``keep_for_late``: subscribers found late get the last messages.

        Raises BagError if a type is not installed or is not the one that was recorded.
        """
        self._path = path
        self._publishers: dict[str, Publisher] = {}
        self._kinds: dict[str, Any] = {}
        self._room: dict[str, bytes] = {}
        self._checked: set[str] = set()
        installed = DefinitionSource()
        for topic in topics.values():
            self._kinds[topic.name] = self._kind(topic, installed)
            profile = self._profile(topic, keep_for_late=keep_for_late)
            self._publishers[topic.name] = node.create_publisher(self._kinds[topic.name], topic.name, profile)

    def is_stamped(self, topic: str) -> bool:
        """Return whether a topic's messages begin with a header."""
        return next(iter(self._kinds[topic].get_fields_and_field_types().values()), "") == _HEADER

    def publish(self, message: StoredMessage) -> None:
        """Publish a message as it was recorded, with room for what its type has got since.

        Raises BagError if a topic's first message is not of the topic's type.
        """
        if message.topic not in self._checked:
            self._check(message)
        self._publishers[message.topic].publish(message.raw + self._room[message.topic])

    def wait_until_heard(self) -> None:
        """Wait until every reliable subscriber has the last messages, for at most a second in all."""
        deadline_ns = time.monotonic_ns() + NS_PER_S
        for publisher in self._publishers.values():
            rest_ns = max(0, deadline_ns - time.monotonic_ns())
            publisher.wait_for_all_acked(Duration(nanoseconds=rest_ns))

    def _kind(self, topic: StoredTopic, installed: DefinitionSource) -> Any:
        """Return a topic's message class."""
        place = f"topic {topic.name}"
        try:
            kind = message_class(topic.type_name)
            definition = installed.find(topic.type_name)
        except LookupError as error:
            raise BagError(self._path, place, f"{error}; or leave the topic out") from error
        type_hash = definition.type_hash
        changed = bool(topic.type_hash and type_hash) and topic.type_hash != type_hash
        grown = changed and bool(topic.definition) and has_grown(topic.definition, definition.text)
        self._room[topic.name] = ROOM if grown else b""
        if changed and not grown:
            problem = f"was recorded with another definition of {topic.type_name} than the one installed"
            raise BagError(self._path, place, f"{problem} ({topic.type_hash[:15]}, {type_hash[:15]})")
        return kind

    def _profile(self, topic: StoredTopic, *, keep_for_late: bool) -> QoSProfile:
        profile = profile_from_offers(topic.offers)
        if keep_for_late:
            profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
        return profile

    def _check(self, message: StoredMessage) -> None:
        """Decode a topic's first message once: bytes of another type would crash or mislead whoever listens."""
        self._checked.add(message.topic)
        try:
            deserialize_message(message.raw + self._room[message.topic], self._kinds[message.topic])
        except Exception as error:  # whatever the type support raises
            place = f"topic {message.topic}, message at {message.log_ns} ns"
            raise BagError(self._path, place, f"does not decode as {message.type_name}: {error}") from error
