"""The GVG level as a node: hears odometry and ranges, says the command and the events, takes goals as actions."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from hslam_msgs.msg import GvgEvent, NodeStatus, SonarRing
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import LaserScan, PointCloud2
from std_srvs.srv import Trigger

from hslam_gvg.gvg_actions import GvgActions
from hslam_gvg.level import CONFIGURATIONS, NONE, RING, Hearing, SourceConfig, gvg_level
from hslam_gvg.local_map_message import local_map_to_msg
from hslam_ros import conversions
from hslam_ros.checks import LARGEST
from hslam_ros.continuity import Continuity
from hslam_ros.door import Door
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE, EVENTS, LATCHED, sensor_subscription
from hslam_ros.scan_conversion import scan_from_msg
from hslam_ros.spin import run
from hslam_ros.stamps import NS_PER_S
from hslam_ros.step_order import TIME, Cycle, StepOrder
from hslam_types import gvg_events
from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample, RangeScan, SonarSweep, Velocity

_STOP_WITHIN_S = 0.5
"""So long a base may take to confirm that it has heard the last command."""


@dataclass(frozen=True)
class GvgNodeConfig(Configuration):
    """How the node is joined to the others, and what it shows."""

    lockstep: bool = parameter(True, "wait for the ranges of every cycle however long it takes")
    hold_back_s: float = parameter(
        0.1, "running free: how long a cycle waits for its ranges", low=0.0, high=5.0, unit="s"
    )
    stamped_command: bool = parameter(True, "say `cmd_vel` as TwistStamped; otherwise as Twist, as most bases want it")
    map_every_s: float = parameter(1.0, "time between two pictures of the local map", low=0.0, high=60.0, unit="s")


class GvgNode(Node):
    """Puts inputs in order of stamp, hands each cycle to the server, publishes what comes of it."""

    def __init__(self) -> None:
        """Declare parameters, topics and actions; raises ConfigurationError on a bad parameter."""
        super().__init__("gvg")
        self._config = declare(self, GvgNodeConfig)
        self._source = declare(self, SourceConfig)
        groups = CONFIGURATIONS[self._source.level]
        self._server = gvg_level(self._source.level, [declare(self, kind, prefix) for prefix, kind in groups])
        hold_ns = None if self._config.lockstep else round(self._config.hold_back_s * NS_PER_S)
        self._order = StepOrder(implicit=["ranges"], hold_ns=hold_ns)
        self._hearing = Hearing()
        self._continuity = Continuity()
        self._events_said = 0
        self._next_map_ns = 0
        self._base_in_odom = SE2()
        self._heard_ns: int | None = None
        """The last cycle driven."""
        self._command: Publisher | None = None
        if self._source.drive != NONE:
            kind = TwistStamped if self._config.stamped_command else Twist
            self._command = self.create_publisher(kind, "cmd_vel", CYCLE)
        self._events = self.create_publisher(GvgEvent, "~/events", EVENTS)
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)
        self._map = self.create_publisher(PointCloud2, "~/local_map", LATCHED)
        sensors = sensor_subscription(self._config.lockstep)
        self._door = Door(self)
        self._door.hear(
            Odometry, "odom", conversions.odometry_from_msg, self._on_odometry, sensors, self._on_refused_odometry
        )
        self._join: Callable[..., Any]
        if self._source.source == RING:
            self._join = self._hearing.sweep
            self._hear_ranges(SonarRing, "sonar", conversions.sonar_from_msg)
        else:
            self._join = self._hearing.scan
            scanner_in_base = self._source.scanner_in_base
            self._hear_ranges(LaserScan, "scan", partial(scan_from_msg, sensor_in_base=scanner_in_base))
        self.create_service(Trigger, "~/reset", self._on_reset)
        self._actions = GvgActions(self, self._server)

    def _hear_ranges(self, kind: type, topic: str, convert: Callable[[Any], SonarSweep | RangeScan]) -> None:
        profile = sensor_subscription(self._config.lockstep)
        self._door.hear(kind, topic, convert, self._on_ranges, profile, self._on_refused_ranges)

    def _on_odometry(self, sample: OdometrySample) -> None:
        self._order.tick(sample.stamp_ns, sample)
        self._work()

    def _on_refused_odometry(self, stamp_ns: int | None) -> None:
        self._order.skip(stamp_ns)
        self._work()

    def _on_ranges(self, heard: SonarSweep | RangeScan) -> None:
        self._order.put("ranges", heard.stamp_ns, heard)
        self._work()

    def _on_refused_ranges(self, stamp_ns: int | None) -> None:
        self._order.miss("ranges", stamp_ns)
        self._work()

    def _work(self) -> None:
        for cycle in self._order.ready():
            self._step(cycle)

    def _step(self, cycle: Cycle) -> None:
        if cycle.skipped:  # who does not know where the robot is does not move it
            self._answer(cycle.stamp_ns, Velocity(), (), "blind")
            return
        odom: OdometrySample = cycle.clock
        self._base_in_odom, self._heard_ns = odom.base_in_odom, cycle.stamp_ns
        broken = cycle.anew.get(TIME) or self._continuity.broken_by(odom)
        if broken:
            self.get_logger().warning(f"{broken}; lost, and the local map is forgotten")
            self._actions.reset()
            self._next_map_ns = 0
        out = self._server.step(odom, self._join(cycle.stamp_ns, cycle.inputs["ranges"]))
        self._answer(cycle.stamp_ns, out.command, out.events, out.state.value)
        self._actions.after_step(out, cycle.stamp_ns)
        if cycle.stamp_ns >= self._next_map_ns and self._map.get_subscription_count():
            self._next_map_ns = cycle.stamp_ns + round(self._config.map_every_s * NS_PER_S)
            self._map.publish(local_map_to_msg(self._server.obstacle_points(), cycle.stamp_ns))

    def _answer(self, stamp_ns: int, command: Velocity, events: tuple[gvg_events.GvgEvent, ...], state: str) -> None:
        self._say(command, stamp_ns)
        for event in events:
            self._events.publish(conversions.event_to_msg(event))
        self._events_said += len(events)
        status = NodeStatus(header=conversions.header(stamp_ns, ""), node=self.get_name(), outputs=self._events_said)
        status.state, status.detail = state, self._door.report()
        status.clearance, status.base_in_odom = (
            min(max(0.0, self._server.room_m), LARGEST),
            conversions.pose_to_msg(self._base_in_odom),
        )
        self._status.publish(status)

    def _say(self, command: Velocity, stamp_ns: int) -> None:
        if self._command is not None:
            msg = conversions.velocity_to_msg(command, stamp_ns)
            self._command.publish(msg if self._config.stamped_command else msg.twist)

    def close(self) -> None:
        """Stop the robot: whoever drives it by the wall clock does not wait for an answer."""
        if self._command is not None and not self._config.lockstep and self._heard_ns is not None:
            self._say(Velocity(), self._heard_ns)
            self._command.wait_for_all_acked(Duration(seconds=_STOP_WITHIN_S))

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._actions.reset()
        response.success, response.message = True, "local map and goal forgotten"
        return response


def main() -> None:
    """Run the node until a signal."""
    run(GvgNode)
