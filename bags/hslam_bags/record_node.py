"""The recorder as a node: finds topics, subscribes to raw bytes, writes them to a bag."""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from hslam_msgs.msg import NodeStatus
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from hslam_bags.definitions import Definition
from hslam_bags.errors import BagError
from hslam_bags.message_types import message_class
from hslam_bags.qos import OfferedQos
from hslam_bags.raw_topics import RawTopics
from hslam_bags.record_configuration import RecordConfiguration
from hslam_bags.recorder import Recorder, RecorderConfig
from hslam_bags.recording_clock import RecordingClock
from hslam_bags.ros_qos import offer_from_profile
from hslam_bags.topic_choice import TopicChoice, names
from hslam_ros.parameters import declare
from hslam_ros.qos import LATCHED
from hslam_ros.spin import run
from hslam_ros.stamps import FOREVER_NS, stamp_to_msg
from hslam_types.errors import ConfigurationError

CLOCK = "/clock"
_SWEEP_S = 0.02
"""Time between two sweeps over the topics; the middleware holds thousands of messages meanwhile."""

_TIMELESS_BYTES = 1 << 20
"""How much is kept in memory waiting for the first stamp or clock; more than that is filed as received."""

Info = dict[str, Any]


class RecordNode(Node):
    """Owns the recorder and a subscription a topic."""

    def __init__(self) -> None:
        """Begin the bag; raises HslamError on a bad parameter or folder."""
        super().__init__("record")
        self._config = declare(self, RecordConfiguration)
        if not self._config.path or self._config.times not in ("stamp", "received"):
            raise ConfigurationError("parameter 'path' must name a folder, 'times' be stamp or received")
        self._choice = TopicChoice(names(self._config.topics), names(self._config.exclude), self._config.hidden)
        self._recorder = Recorder(Path(self._config.path), declare(self, RecorderConfig))
        self._times = RecordingClock()
        self._heard = RawTopics(self)
        self._publisher_counts: dict[str, int] = {}
        self._timeless: list[tuple[str, str, bytes, Info]] = []
        self._timeless_bytes = 0
        self._status = self.create_publisher(NodeStatus, "~/status", LATCHED)
        self._required = {self.resolve_topic_name(name) for name in names(self._config.require)}
        self.failure: BagError | None = None
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timers_of_recording = [
            self.create_timer(_SWEEP_S, partial(self._try, self._heard.sweep), clock=steady),
            self.create_timer(self._config.find_every_s, self._find_topics, clock=steady),
            self.create_timer(self._config.flush_every_s, partial(self._try, self._recorder.flush), clock=steady),
        ]
        self._find_topics()

    @property
    def recorded(self) -> int:
        """Messages recorded so far."""
        return self._recorder.message_count

    @property
    def heard(self) -> int:
        """Messages heard so far: recorded, or kept until there is a time."""
        return self._recorder.message_count + len(self._timeless)

    def _find_topics(self) -> None:
        """Listen to what is new, and to what has a new publisher."""
        for topic, types in sorted(self.get_topic_names_and_types()):
            if topic not in self._choice or topic == self._status.topic_name:
                continue
            publishers = self.count_publishers(topic)
            if publishers == self._publisher_counts.get(topic, 0):
                continue
            self._publisher_counts[topic] = publishers
            offers = tuple(offer_from_profile(info.qos_profile) for info in self.get_publishers_info_by_topic(topic))
            if offers and topic in self._heard:
                self._heard.adapt(topic, offers)
            elif offers:
                self._listen(topic, types[0], offers)
        self._announce()

    def _listen(self, topic: str, type_name: str, offers: tuple[OfferedQos, ...]) -> None:
        try:
            kind = message_class(type_name)
            definition = self._recorder.add_topic(topic, type_name, offers)
        except (LookupError, BagError) as error:
            self.get_logger().warning(f"{topic} is not recorded: {error}")
            return
        self._heard.listen(topic, kind, offers, partial(self._handler(topic, definition), topic, type_name))

    def _handler(self, topic: str, definition: Definition) -> Callable[[str, str, bytes, Info], None]:
        """Choose how a topic's messages get their times."""
        if self._config.times == "received":
            return self._record_received
        if topic == CLOCK:
            return self._record_clock
        return self._record_stamped if definition.stamped else self._record_unstamped

    def _record_stamped(self, topic: str, type_name: str, raw: bytes, info: Info) -> None:
        self._record_at(self._times.stamp_ns(raw), topic, type_name, raw, info)

    def _record_unstamped(self, topic: str, type_name: str, raw: bytes, info: Info) -> None:
        self._record_at(self._times.newest_ns, topic, type_name, raw, info)

    def _record_clock(self, topic: str, type_name: str, raw: bytes, info: Info) -> None:
        self._record_at(self._times.tick(raw), topic, type_name, raw, info)

    def _record_received(self, topic: str, type_name: str, raw: bytes, info: Info) -> None:
        self._recorder.write(topic, type_name, raw, info["received_timestamp"], info["source_timestamp"])

    def _record_at(self, time_ns: int | None, topic: str, type_name: str, raw: bytes, info: Info) -> None:
        """Record a message, or keep it until there is a time: log lines of starting nodes come before the first."""
        if time_ns is None:
            self._timeless.append((topic, type_name, raw, info))
            self._timeless_bytes += len(raw)
            if self._timeless_bytes > _TIMELESS_BYTES:
                self._record_timeless(None)
            return
        if self._timeless:
            self._record_timeless(time_ns)
        self._recorder.write(topic, type_name, raw, time_ns)

    def _record_timeless(self, time_ns: int | None) -> None:
        """Record what was kept at the first time there is; None: there will be none, so as received."""
        for topic, type_name, raw, info in self._timeless:
            if time_ns is None:
                self._record_received(topic, type_name, raw, info)
            else:
                self._recorder.write(topic, type_name, raw, time_ns)
        self._timeless.clear()

    def _announce(self) -> None:
        """Say once that every required topic is heard, to whoever waits for this recorder with the first step."""
        if self._required and all(self._heard.has_publisher(topic) for topic in self._required):
            # A recorder is waited for once, not at every step.
            status = NodeStatus(node=self.get_name(), state="recording")
            status.header.stamp = stamp_to_msg(FOREVER_NS)
            self._status.publish(status)
            self._required = set()

    def close(self) -> None:
        """Take what has arrived but not been handled, and end the bag."""
        if self.failure is None:
            self._try(self._end)
        if self.failure is not None:
            sys.stderr.write(f"{self.get_name()}: {self.failure}\n")
        self._heard.close()

    def _end(self) -> None:
        self._heard.sweep()
        self._record_timeless(None)
        self._recorder.close()

    def _try(self, action: Callable[[], object]) -> None:
        """Do something unless recording has failed; a failure is kept and ends the node (executors would shout it)."""
        if self.failure is None:
            try:
                action()
            except BagError as error:
                self.failure = error


def main() -> None:
    """Run the node until Ctrl-C or SIGTERM; exits 1 with one line if the bag could not be written to the end."""
    nodes: list[RecordNode] = []

    def make() -> RecordNode:
        nodes.append(RecordNode())
        return nodes[0]

    try:
        run(make, done=lambda _: nodes[0].failure is not None)
    finally:
        if nodes and nodes[0].failure is not None:
            sys.exit(1)
