"""The node: one goal at a time, each answered with its own end, however late or often it is sent."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point, Twist, TwistStamped
from hslam_msgs.action import AccessGvg, DriveStraight, TraceEdge
from hslam_msgs.msg import GvgEvent, NodeStatus, SonarRing
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.node import Node
from ros_stage import Stage, Staged
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger

from hslam_gvg.config import GvgConfig
from hslam_gvg.gvg_actions import _OFFERS
from hslam_gvg.gvg_node import GvgNode
from hslam_gvg.level import Hearing
from hslam_gvg.server import GvgServer
from hslam_ros import conversions
from hslam_ros.qos import CYCLE, EVENTS, LATCHED
from hslam_ros.stamps import stamp_to_msg
from hslam_types.gvg_events import NodeKind, NodeView
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, OdometrySample, SonarPing, SonarSweep

STEP_NS = 120_000_000


class Rest(Node):
    """The base, standing in silence, and whoever sends goals."""

    def __init__(self) -> None:
        super().__init__("rest")
        self.events: list[GvgEvent] = []
        self.statuses: list[NodeStatus] = []
        self.odom = self.create_publisher(Odometry, "odom", CYCLE)
        self.sonar = self.create_publisher(SonarRing, "sonar", CYCLE)
        self.create_subscription(GvgEvent, "gvg/events", self.events.append, EVENTS)
        self.create_subscription(NodeStatus, "gvg/status", self.statuses.append, CYCLE)
        self.access: Any = ActionClient(self, AccessGvg, "gvg/access")
        self.trace: Any = ActionClient(self, TraceEdge, "gvg/trace")
        self.straight: Any = ActionClient(self, DriveStraight, "gvg/drive_straight")
        self.reset: Any = self.create_client(Trigger, "gvg/reset")


class Pair(Stage):
    """The node and the rest."""

    def __init__(self, **parameters: object) -> None:
        super().__init__(**parameters)
        self.gvg, self.rest, self.stamp_ns = self.add(GvgNode()), self.add(Rest()), 0
        for client in (self.rest.access, self.rest.trace, self.rest.straight):
            self.spin_until(client.server_is_ready)

    def cycle(self, odom: SE2 = SE2(), pings: tuple[SonarPing, ...] = ()) -> None:  # noqa: B008 (immutable)
        """Say one cycle and wait for its answer."""
        self.stamp_ns += STEP_NS
        answered = len(self.rest.statuses)
        self.rest.odom.publish(conversions.odometry_to_msg(OdometrySample(self.stamp_ns, odom)))
        self.rest.sonar.publish(conversions.sonar_to_msg(SonarSweep(self.stamp_ns, SCOUT_RING, pings)))
        self.spin_until(lambda: len(self.rest.statuses) > answered)

    def send(self, client: Any, goal: Any) -> Any:
        """Send a goal and return its handle."""
        return self.wait(client.send_goal_async(goal))

    def result(self, handle: Any) -> Any:
        """Return how a goal ended."""
        return self.wait(handle.get_result_async()).result

    @property
    def ring_level(self) -> GvgServer:
        """The node's server, which hears a ring by default."""
        assert isinstance(self.gvg._server, GvgServer)
        return self.gvg._server

    def stand_at_node(self) -> None:
        """Put the robot at a meet point, facing its first branch."""
        self.ring_level._now.node = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, (0.0, 2.0, -2.0))


@pytest.fixture
def pair(staged: Staged) -> Pair:
    return staged(Pair)


def test_a_reset_aborts_the_goal_and_counts_events_on(pair: Pair) -> None:
    for sequence in (0, 1):
        handle = pair.send(pair.rest.access, AccessGvg.Goal())
        pair.cycle()
        assert pair.rest.statuses[-1].state == "listening"
        assert pair.wait(pair.rest.reset.call_async(Trigger.Request())).success
        pair.cycle()
        result = pair.result(handle)
        assert (result.success, result.message) == (False, "reset")
        pair.spin_until(lambda sequence=sequence: len(pair.rest.events) > sequence)  # type: ignore[misc]
        assert [event.sequence for event in pair.rest.events] == list(range(sequence + 1))
        assert {event.kind for event in pair.rest.events} == {GvgEvent.LOST}


def test_a_goal_sent_again_is_the_goal_under_way(pair: Pair) -> None:
    pair.cycle()
    pair.stand_at_node()
    goal = TraceEdge.Goal(branch=0, decided=stamp_to_msg(pair.stamp_ns - 1))
    first = pair.send(pair.rest.trace, goal)
    pair.cycle()
    assert pair.rest.statuses[-1].state == "tracing"
    again = pair.send(pair.rest.trace, goal)
    assert first.accepted
    assert again.accepted
    assert not pair.send(pair.rest.trace, TraceEdge.Goal(branch=1, decided=goal.decided)).accepted
    pair.cycle()
    assert pair.rest.statuses[-1].state == "tracing"
    pair.spin_until(lambda: len(pair.rest.events) > 0)
    assert [event.kind for event in pair.rest.events] == [GvgEvent.DEPARTURE]
    assert pair.wait(pair.rest.reset.call_async(Trigger.Request())).success
    assert pair.result(again).message == "reset"


def test_a_goal_in_the_middle_of_an_edge_is_not_answered_by_the_loss_that_it_brings(pair: Pair) -> None:
    pair.cycle()
    pair.stand_at_node()
    trace = pair.send(pair.rest.trace, TraceEdge.Goal(branch=0))
    pair.cycle()
    straight = pair.send(pair.rest.straight, DriveStraight.Goal(target=Point(x=2.0)))
    assert pair.result(trace).message == "a new goal took its place"
    for state in ("idle", "straight"):
        pair.cycle()
        assert pair.rest.statuses[-1].state == state
    pair.spin_until(lambda: len(pair.rest.events) > 1)
    assert [event.kind for event in pair.rest.events] == [GvgEvent.DEPARTURE, GvgEvent.LOST]
    access = pair.send(pair.rest.access, AccessGvg.Goal())
    assert pair.result(straight).message == "a new goal took its place"
    pair.wait(access.cancel_goal_async())
    pair.cycle()
    assert pair.result(access).message == "cancelled"


def test_a_goal_dropped_is_answered_and_the_node_lives_on(pair: Pair) -> None:
    pair.cycle()
    pair.stand_at_node()
    pair.send(pair.rest.trace, TraceEdge.Goal(branch=0))
    late = pair.send(pair.rest.trace, TraceEdge.Goal(branch=0, decided=stamp_to_msg(pair.stamp_ns)))
    assert late.accepted
    pair.ring_level._now.node = None
    pair.cycle()
    pair.cycle()
    result = pair.result(late)
    assert not result.success
    assert "at no node" in result.message
    pair.cycle()


@pytest.mark.parametrize(
    ("action", "goal", "expected"),
    [
        ("access", AccessGvg.Goal(), AccessGvg.Feedback(state="listening", clearance=GvgConfig().wide_m)),
        ("trace", TraceEdge.Goal(branch=0), TraceEdge.Feedback(state="tracing", path_length=0.0)),
        (
            "straight",
            DriveStraight.Goal(target=Point(x=2.0)),
            DriveStraight.Feedback(state="straight", distance_left=2.0),
        ),
    ],
)
def test_a_goal_under_way_says_how_far_it_has_come(pair: Pair, action: str, goal: Any, expected: Any) -> None:
    pair.cycle()
    pair.stand_at_node()
    heard: list[Any] = []
    client = getattr(pair.rest, action)
    pair.wait(client.send_goal_async(goal, feedback_callback=lambda msg: heard.append(msg.feedback)))
    pair.cycle()
    pair.spin_until(lambda: len(heard) > 0)
    assert heard == [expected]


def test_a_cycle_without_pings_keeps_the_ring_last_heard() -> None:
    other, hearing = replace(SCOUT_RING, mount_radius_m=0.3), Hearing()
    assert hearing.sweep(1, (SonarSweep(1, other, ()),)).ring == other
    assert hearing.sweep(2, ()) == SonarSweep(2, other, ())


class Handle:
    """An action's goal handle that is executed when the test says so."""

    def __init__(self, name: bytes) -> None:
        self.goal_id = type("GoalId", (), {"uuid": name})
        self.is_cancel_requested = False

    def execute(self) -> None:
        """Leave it to the executor, later."""

    def abort(self) -> None:
        """End without success."""

    def canceled(self) -> None:
        """End as the client wished."""


def test_two_goals_that_end_together_are_answered_each_with_its_own_end(pair: Pair) -> None:
    actions, first, second = pair.gvg._actions, Handle(b"first"), Handle(b"second")
    actions._on_accepted(_OFFERS["~/access"], first)
    actions._on_accepted(_OFFERS["~/access"], second)
    actions.reset()
    messages = [actions._on_end(AccessGvg, handle).message for handle in (first, second)]
    assert messages == ["a new goal took its place", "reset"]


def test_a_cancelled_goal_has_not_succeeded(pair: Pair) -> None:
    actions, handle = pair.gvg._actions, Handle(b"unwanted")
    actions._on_accepted(_OFFERS["~/access"], handle)
    handle.is_cancel_requested = True
    actions._on_cancel(handle)
    pair.cycle()
    result = actions._on_end(AccessGvg, handle)
    assert (result.success, result.message) == (False, "cancelled")


def test_the_local_map_is_said_to_whoever_listens(pair: Pair) -> None:
    clouds: list[PointCloud2] = []
    pair.rest.create_subscription(PointCloud2, "gvg/local_map", clouds.append, LATCHED)
    pair.spin_until(lambda: pair.gvg._map.get_subscription_count() > 0)
    pair.ring_level.map.touch(SE2(), direction=1.0)
    pair.cycle()
    pair.spin_until(lambda: len(clouds) > 0)
    cloud = clouds[0]
    assert cloud.header.frame_id == "odom"
    assert [(field.name, field.offset) for field in cloud.fields] == [("x", 0), ("y", 4), ("z", 8)]
    points = np.frombuffer(cloud.data, dtype="<f4").reshape(cloud.width, 3)
    believed = pair.ring_level.map.points()
    assert len(believed) > 0
    np.testing.assert_allclose(points, np.column_stack((believed, np.zeros(len(believed)))), atol=1e-6)


def test_what_is_refused_stops_the_robot_for_a_cycle_and_is_told(pair: Pair) -> None:
    commands: list[TwistStamped] = []
    pair.rest.create_subscription(TwistStamped, "cmd_vel", commands.append, CYCLE)
    said = pair.gvg._command
    assert said is not None
    pair.spin_until(lambda: said.get_subscription_count() > 0)
    pair.cycle()
    pair.send(pair.rest.straight, DriveStraight.Goal(target=Point(x=2.0)))
    pair.cycle()
    pair.spin_until(lambda: len(commands) == 2)
    assert commands[-1].twist.linear.x > 0.0
    pair.cycle(odom=SE2(math.nan, 0.0, 0.0))
    pair.spin_until(lambda: len(commands) == 3)
    assert (commands[-1].twist.linear.x, commands[-1].twist.angular.z) == (0.0, 0.0)
    assert pair.rest.statuses[-1].state == "blind"
    pair.cycle(pings=(SonarPing(16, pair.stamp_ns, 1.0),))
    pair.spin_until(lambda: len(commands) == 4)
    assert commands[-1].twist.linear.x > 0.0
    assert pair.rest.statuses[-1].state == "straight"
    assert pair.rest.statuses[-1].detail == "refused messages: odom 1, sonar 1"


@pytest.mark.parametrize("broken", ["time", "pose"])
def test_what_begins_anew_is_a_loss_and_goals_are_taken_again(pair: Pair, broken: str) -> None:
    """A clock that is set, a base that is carried away: the goal is aborted and LOST announced, once."""
    pair.stamp_ns = 10**12
    pair.cycle()
    handle = pair.send(pair.rest.access, AccessGvg.Goal())
    pair.cycle()
    assert pair.rest.statuses[-1].state == "listening"
    if broken == "time":
        pair.stamp_ns = 10**9
    carried = SE2(7.0, 0.0, 0.0) if broken == "pose" else SE2()
    pair.cycle(odom=carried)
    assert pair.rest.statuses[-1].state == "idle"
    assert not pair.result(handle).success
    pair.cycle(odom=carried)
    pair.spin_until(lambda: bool(pair.rest.events))
    assert [event.kind for event in pair.rest.events] == [GvgEvent.LOST]
    pair.send(pair.rest.access, AccessGvg.Goal())
    pair.cycle(odom=carried)
    assert pair.rest.statuses[-1].state == "listening"


@pytest.mark.parametrize(("stamped", "kind"), [(True, TwistStamped), (False, Twist)])
def test_a_base_gets_its_command_as_it_wants_it_and_is_stopped_at_the_end(
    staged: Staged, stamped: bool, kind: type
) -> None:
    pair = staged(Pair, stamped_command=stamped, lockstep=False, hold_back_s=0.0)
    heard: list[Any] = []
    pair.rest.create_subscription(kind, "cmd_vel", heard.append, CYCLE)
    pair.spin_until(lambda: pair.gvg.count_subscribers("cmd_vel") == 1)
    pair.gvg.close()  # nothing was heard yet: there is nothing to stop
    for _ in range(3):
        pair.cycle()
    pair.spin_until(lambda: len(heard) == 3)
    pair.gvg.close()
    pair.spin_until(lambda: len(heard) == 4)
    twist = heard[-1].twist if stamped else heard[-1]
    assert (twist.linear.x, twist.angular.z) == (0.0, 0.0)
