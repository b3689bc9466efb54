"""The door hands on what can be used; it counts, tells and forgets the rest."""

import math
from collections.abc import Callable
from typing import Any, cast

import pytest
from geometry_msgs.msg import TwistStamped
from rclpy.node import Node

from hslam_ros import conversions
from hslam_ros.door import Door, stamped
from hslam_ros.qos import CYCLE
from hslam_types.errors import MessageError
from hslam_types.sensing import Velocity


class Listener:
    """What a door needs of a node; says nothing aloud."""

    def __init__(self) -> None:
        self.callbacks: dict[str, Callable[[Any], None]] = {}
        self.lines: list[str] = []
        self.now_s = 100.0
        self.taken: list[tuple[int, Velocity]] = []
        self.refused: list[int | None] = []
        self.door = Door(cast("Node", self), lambda: self.now_s)
        for topic in ("cmd_vel", "teleop"):
            self.door.hear(
                TwistStamped,
                topic,
                stamped(conversions.velocity_from_msg),
                self.taken.append,
                CYCLE,
                self.refused.append,
            )

    def create_subscription(self, _: type, topic: str, callback: Callable[[Any], None], __: Any) -> None:
        """Keep the callback."""
        self.callbacks[topic] = callback

    def get_logger(self) -> "Listener":
        """Return who keeps the lines."""
        return self

    def warning(self, line: str) -> None:
        """Keep a line."""
        self.lines.append(line)

    def hear(self, forward: float, stamp_ns: int = 7, topic: str = "cmd_vel") -> None:
        """Receive a command."""
        self.callbacks[topic](conversions.velocity_to_msg(Velocity(forward, 0.0), stamp_ns))


@pytest.fixture
def listener() -> Listener:
    return Listener()


def test_a_good_message_is_handed_on_converted(listener: Listener) -> None:
    listener.hear(0.5)
    assert listener.taken == [(7, Velocity(0.5, 0.0))]
    assert (listener.refused, listener.lines, listener.door.refused, listener.door.report()) == ([], [], 0, "")


def test_a_bad_message_goes_no_further_and_its_stamp_is_told_where_it_is_one(listener: Listener) -> None:
    listener.hear(math.nan)
    listener.hear(0.5, stamp_ns=-(10**9))
    listener.hear(0.25)
    assert listener.taken == [(7, Velocity(0.25, 0.0))]
    assert listener.refused == [7, None]
    assert listener.door.refused == 2
    assert listener.door.report() == "refused messages: cmd_vel 2"


def test_each_topic_speaks_once_a_second_and_tells_how_many_it_kept_to_itself(listener: Listener) -> None:
    for _ in range(5):
        listener.hear(math.nan)
        listener.now_s += 0.125
    listener.hear(math.inf, topic="teleop")
    assert listener.lines == [
        "message on cmd_vel refused: twist.linear.x = nan is no number from -1e+06 to 1e+06",
        "message on teleop refused: twist.linear.x = inf is no number from -1e+06 to 1e+06",
    ]
    listener.now_s += 0.375
    listener.hear(math.nan)
    assert listener.lines[2:] == [
        "message on cmd_vel refused (5 since the last line): twist.linear.x = nan is no number from -1e+06 to 1e+06"
    ]
    assert listener.door.report() == "refused messages: cmd_vel 6, teleop 1"


def test_who_takes_a_message_may_refuse_it_too(listener: Listener) -> None:
    def contradict(_: Any) -> None:
        raise MessageError("repeats the last one")

    listener.door.hear(TwistStamped, "again", conversions.velocity_from_msg, contradict, CYCLE)
    listener.hear(0.5, topic="again")
    assert listener.lines == ["message on again refused: repeats the last one"]
