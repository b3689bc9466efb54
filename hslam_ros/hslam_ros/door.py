"""Where messages come into a node: converted and handed on, or refused, counted and told."""

import time
from collections import Counter
from collections.abc import Callable
from typing import Any, TypeVar

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from hslam_ros.checks import stamp
from hslam_types.errors import MessageError

V = TypeVar("V")

_QUIET_S = 1.0
"""Time between two lines on one topic."""


class Door:
    """The subscriptions of a node. What their conversions refuse (MessageError) never gets further than here."""

    def __init__(self, node: Node, now_s: Callable[[], float] = time.monotonic) -> None:
        """Open the door of ``node``; ``now_s`` tells when to speak again."""
        self._node, self._now_s = node, now_s
        self._refused: Counter[str] = Counter()
        self._told: dict[str, tuple[float, int]] = {}

    def hear(
        self,
        kind: type,
        topic: str,
        convert: Callable[[Any], V],
        take: Callable[[V], None],
        qos: QoSProfile,
        refused: Callable[[int | None], None] = lambda _: None,
    ) -> Subscription:
        """Subscribe to a topic: ``take`` gets what ``convert`` makes of each message; both may refuse it.

        ``refused`` is called in its stead for a message that is refused, with the stamp (ns) of its header, None where
        that is no time either: others may count on what becomes of it.
        """

        def on_message(msg: Any) -> None:
            try:
                take(convert(msg))
            except MessageError as error:
                self._refuse(topic, error)
                refused(_stamp_of(msg))

        return self._node.create_subscription(kind, topic, on_message, qos)

    @property
    def refused(self) -> int:
        """How many messages were refused so far."""
        return self._refused.total()

    def report(self) -> str:
        """Tell what was refused so far, for a status or diagnostics; empty where nothing was."""
        counts = ", ".join(f"{topic} {count}" for topic, count in sorted(self._refused.items()))
        return f"refused messages: {counts}" if counts else ""

    def _refuse(self, topic: str, error: MessageError) -> None:
        self._refused[topic] += 1
        now_s, count = self._now_s(), self._refused[topic]
        told_s, told = self._told.get(topic, (now_s - _QUIET_S, 0))
        if now_s - told_s >= _QUIET_S:
            self._told[topic] = now_s, count
            since = f" ({count - told} since the last line)" if count - told > 1 else ""
            self._node.get_logger().warning(f"message on {topic} refused{since}: {error}")


def stamped(convert: Callable[[Any], V]) -> Callable[[Any], tuple[int, V]]:
    """Return the conversion of a message to the stamp (ns) of its header and what ``convert`` makes of it."""
    return lambda msg: (stamp(msg.header.stamp), convert(msg))


def _stamp_of(msg: Any) -> int | None:
    try:
        return stamp(msg.header.stamp)
    except MessageError:
        return None
