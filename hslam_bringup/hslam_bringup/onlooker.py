"""Follows a run of separate processes from outside, for the display alone."""

from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from hslam_msgs.msg import Atlas
from rclpy.node import Node

from hslam_bringup.progress import Snapshot
from hslam_ros.qos import LATCHED
from hslam_ros.stamps import NS_PER_S, stamp_from_msg

ODOMETER = "odometer_m"
"""Key under which a base's diagnostics tell how far its wheels have gone."""


class Onlooker:
    """Takes the newest atlas and diagnostics when it looks.

    Neither comes every cycle, and no executor spins the subscriptions: being looked at costs the run nothing.
    """

    def __init__(self, domain: int) -> None:
        """Join the ROS domain of the run."""
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = Node("hslam_onlooker", context=self._context, enable_rosout=False, start_parameter_services=False)
        self._subscriptions = {
            kind: self._node.create_subscription(kind, topic, lambda _: None, qos)
            for kind, topic, qos in ((Atlas, "atlas/atlas", LATCHED), (DiagnosticArray, "/diagnostics", 10))
        }
        self._newest: dict[type, Any] = {}

    def look(self) -> Snapshot | None:
        """Return where the run stands, or None before it has begun."""
        for kind, subscription in self._subscriptions.items():
            with subscription.handle:
                while (taken := subscription.handle.take_message(kind, False)) is not None:
                    if kind is not DiagnosticArray or _is_of_a_base(taken[0]):
                        self._newest[kind] = taken[0]
        health: DiagnosticArray | None = self._newest.get(DiagnosticArray)
        if health is None:
            return None
        atlas: Atlas = self._newest.get(Atlas, Atlas())
        sim_time_s = stamp_from_msg(health.header.stamp) / NS_PER_S
        unexplored = sum(edge < 0 for node in atlas.nodes for edge in node.edges)
        return Snapshot(sim_time_s, len(atlas.nodes), len(atlas.edges), unexplored, _odometer_m(health))

    def close(self) -> None:
        """Stop following."""
        self._node.destroy_node()
        self._context.try_shutdown()


def _is_of_a_base(health: DiagnosticArray) -> bool:
    return any(pair.key == ODOMETER for status in health.status for pair in status.values)


def _odometer_m(health: DiagnosticArray) -> float:
    """Return the distance the base's wheels have gone, 0 where nothing tells it."""
    figures = {pair.key: pair.value for status in health.status for pair in status.values}
    return float(figures.get(ODOMETER, 0.0))
