"""Hands goals to the GVG level's action servers, and says when they have been taken."""

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Point
from hslam_msgs.action import AccessGvg, DriveStraight, TraceEdge
from rclpy.action import ActionClient
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.task import Future

from hslam_ros.stamps import stamp_to_msg
from hslam_types.gvg_events import GoalKind, GvgGoal

_LOOK_S = 0.2
"""How often a server that is not there yet is looked for."""
_RESEND_LOOKS = 5
"""Looks without an answer after which a goal is sent again: DDS may lose the first answer of a new server."""


class GvgClient:
    """Sends one goal at a time; a server that is not there yet is waited for, a lost answer asked for again.

    A goal sent twice does no harm: the GVG level stands still until a later cycle than the answer's.
    """

    def __init__(self, node: Node, source: str) -> None:
        """Create the clients of the actions under the name ``source``."""
        self._clients: dict[GoalKind, Any] = {
            GoalKind.ACCESS: ActionClient(node, AccessGvg, f"{source}/access"),
            GoalKind.TRACE: ActionClient(node, TraceEdge, f"{source}/trace"),
            GoalKind.STRAIGHT: ActionClient(node, DriveStraight, f"{source}/drive_straight"),
        }
        self._goal: GvgGoal | None = None
        self._decided_ns = 0
        self._answered: Callable[[bool], None] = lambda _: None
        self._looks = 0
        self._timer = node.create_timer(_LOOK_S, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def send(self, goal: GvgGoal, decided_ns: int, answered: Callable[[bool], None]) -> None:
        """Send a goal that the cycle ``decided_ns`` led to.

        ``answered(accepted)`` is called once, when the server has decided on it.
        """
        if goal.kind is GoalKind.STOP:  # nothing to ask for: without a goal the GVG level stands still
            answered(True)
            return
        self._goal, self._decided_ns, self._answered, self._looks = goal, decided_ns, answered, 0
        self._try()

    def _try(self) -> None:
        goal = self._goal
        if goal is None or not self._clients[goal.kind].server_is_ready():
            return
        self._looks = _RESEND_LOOKS
        future = self._clients[goal.kind].send_goal_async(_to_msg(goal, self._decided_ns))
        future.add_done_callback(lambda done: self._on_answer(goal, done))

    def _on_answer(self, goal: GvgGoal, done: Future) -> None:
        if self._goal is goal:  # else: the answer to the first of two sendings came late
            self._goal = None
            self._answered(_accepted(done))

    def _look(self) -> None:
        self._looks -= 1
        if self._goal is not None and self._looks <= 0:
            self._try()


def _to_msg(goal: GvgGoal, decided_ns: int) -> Any:
    decided = stamp_to_msg(decided_ns)
    if goal.kind is GoalKind.TRACE:
        return TraceEdge.Goal(branch=goal.branch, decided=decided)
    if goal.kind is GoalKind.STRAIGHT:
        target = Point(x=goal.x_in_odom, y=goal.y_in_odom)
        return DriveStraight.Goal(target=target, decided=decided)
    way = goal.heading_in_odom
    return AccessGvg.Goal(decided=decided, one_way=way is not None, heading=way or 0.0)


def _accepted(future: Future) -> bool:
    handle = future.result()
    return handle is not None and bool(handle.accepted)
