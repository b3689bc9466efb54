"""Follows an exploration by a real robot, for the display and to know its end."""

import math
from typing import Any

import rclpy
from hslam_msgs.msg import Atlas, NodeStatus
from rclpy.node import Node

from hslam_bringup.progress import Snapshot
from hslam_ros.qos import CYCLE, LATCHED
from hslam_ros.stamps import NS_PER_S, stamp_from_msg


class LiveOnlooker:
    """Takes the newest atlas and statuses when it looks, in the ROS domain that the environment names."""

    def __init__(self) -> None:
        """Join the domain."""
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = Node("hslam_onlooker", context=self._context, enable_rosout=False, start_parameter_services=False)
        self._subscriptions = {
            (kind, topic): self._node.create_subscription(kind, topic, lambda _: None, qos)
            for kind, topic, qos in (
                (Atlas, "atlas/atlas", LATCHED),
                (NodeStatus, "atlas/status", CYCLE),
                (NodeStatus, "gvg/status", CYCLE),
            )
        }
        self.finished = False
        """Whether the mission has come to its end."""
        self._atlas = Atlas()
        self._path_length_m = 0.0
        self._last_xy: tuple[float, float] | None = None
        self._first_s: float | None = None
        self._now_s = 0.0

    def look(self) -> Snapshot | None:
        """Return where the exploration stands, or None before the robot was heard."""
        for (kind, topic), subscription in self._subscriptions.items():
            with subscription.handle:
                while (taken := subscription.handle.take_message(kind, False)) is not None:
                    self._take(topic, taken[0])
        if self._first_s is None:
            return None
        unexplored = sum(edge < 0 for node in self._atlas.nodes for edge in node.edges)
        nodes, edges = len(self._atlas.nodes), len(self._atlas.edges)
        return Snapshot(self._now_s - self._first_s, nodes, edges, unexplored, self._path_length_m)

    def close(self) -> None:
        """Stop following."""
        self._node.destroy_node()
        self._context.try_shutdown()

    def _take(self, topic: str, msg: Any) -> None:
        if topic == "atlas/atlas":
            self._atlas = msg
        elif topic == "atlas/status":
            self.finished |= msg.finished
        else:
            here = msg.base_in_odom.x, msg.base_in_odom.y
            self._path_length_m += math.dist(self._last_xy or here, here)
            self._last_xy = here
            self._now_s = stamp_from_msg(msg.header.stamp) / NS_PER_S
            if self._first_s is None:
                self._first_s = self._now_s
