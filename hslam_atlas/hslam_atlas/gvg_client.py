"""Hands goals to the GVG level's action servers, and says when they have been taken."""

from collections.abc import Callable
from typing import Any

from hslam_msgs.action import AccessGvg, DriveStraight, TraceEdge
from rclpy.action import ActionClient
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.task import Future

from hslam_types.gvg_events import GoalKind, GvgGoal

_RETRY_S = 0.2


class GvgClient:
    """Sends one goal at a time; a server that is not there yet is waited for."""

    def __init__(self, node: Node, source: str) -> None:
        """Create the clients of the actions under the name ``source``."""
        self._node = node
        self._clients: dict[GoalKind, Any] = {
            GoalKind.ACCESS: ActionClient(node, AccessGvg, f"{source}/access"),
            GoalKind.TRACE: ActionClient(node, TraceEdge, f"{source}/trace"),
            GoalKind.STRAIGHT: ActionClient(node, DriveStraight, f"{source}/drive_straight"),
        }
        self._waiting: tuple[GvgGoal, Callable[[bool], None]] | None = None
        self._timer = node.create_timer(_RETRY_S, self._try_again, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def send(self, goal: GvgGoal, answered: Callable[[bool], None]) -> None:
        """Send a goal; ``answered(accepted)`` is called when the server has decided on it."""
        if goal.kind is GoalKind.STOP:  # nothing to ask for: without a goal the GVG level stands still
            answered(True)
            return
        client = self._clients[goal.kind]
        if not client.server_is_ready():
            self._waiting = (goal, answered)
            return
        future = client.send_goal_async(_to_msg(goal))
        future.add_done_callback(lambda done: answered(_accepted(done)))

    def _try_again(self) -> None:
        if self._waiting is not None:
            waiting, self._waiting = self._waiting, None
            self.send(*waiting)


def _to_msg(goal: GvgGoal) -> Any:
    if goal.kind is GoalKind.TRACE:
        return TraceEdge.Goal(branch=goal.branch)
    if goal.kind is GoalKind.STRAIGHT:
        msg = DriveStraight.Goal()
        msg.target.x, msg.target.y = goal.x_in_odom, goal.y_in_odom
        return msg
    return AccessGvg.Goal()


def _accepted(future: Future) -> bool:
    handle = future.result()
    return handle is not None and bool(handle.accepted)
