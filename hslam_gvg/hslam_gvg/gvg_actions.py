"""The GVG level's goals as ROS actions: one goal at a time, a new one takes the place of the last."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from hslam_msgs.action import AccessGvg, DriveStraight, TraceEdge
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node

from hslam_gvg.level import GvgLevel
from hslam_gvg.states import GvgError, GvgOutput, GvgState
from hslam_ros.stamps import NS_PER_S, stamp_from_msg
from hslam_types.gvg_events import EventKind, GoalKind, GvgGoal

_FEEDBACK_NS = NS_PER_S
"""Time between two feedbacks: in lock-step one a cycle would cost every listener time."""


class _Offer(NamedTuple):
    """An action, the goal its requests ask for, and what is said on the way by the keywords of its feedback."""

    kind: Any
    to_goal: Callable[[Any], GvgGoal]
    progress: Callable[[GvgLevel], dict[str, float]]


_OFFERS = {
    "~/access": _Offer(
        AccessGvg,
        lambda goal: GvgGoal(GoalKind.ACCESS, heading_in_odom=goal.heading if goal.one_way else None),
        lambda gvg: {"clearance": gvg.room_m},
    ),
    "~/trace": _Offer(
        TraceEdge,
        lambda goal: GvgGoal(GoalKind.TRACE, branch=int(goal.branch)),
        lambda gvg: {"path_length": gvg.path_length_m},
    ),
    "~/drive_straight": _Offer(
        DriveStraight,
        lambda goal: GvgGoal(GoalKind.STRAIGHT, x_in_odom=goal.target.x, y_in_odom=goal.target.y),
        lambda gvg: {"distance_left": gvg.distance_left_m},
    ),
}


class GvgActions:
    """Takes goals for the server and answers each when an event, or a new goal, has ended it."""

    def __init__(self, node: Node, server: GvgLevel) -> None:
        """Offer the actions on ``node``."""
        self._node, self._server = node, server
        self._handle: Any = None
        self._offer = _OFFERS["~/access"]
        self._next_feedback_ns = 0
        self._results: dict[bytes, tuple[bool, str, int]] = {}
        self._servers = [
            ActionServer(
                node,
                offer.kind,
                name,
                partial(self._on_end, offer.kind),
                goal_callback=partial(self._on_request, offer.to_goal),
                handle_accepted_callback=partial(self._on_accepted, offer),
                cancel_callback=self._on_cancel,
            )
            for name, offer in _OFFERS.items()
        ]

    def reset(self) -> None:
        """Reset the server; the goal under way is aborted."""
        self._server.reset()
        self._next_feedback_ns = 0
        if self._handle is not None:
            self._finish(success=False, message="reset", event=0)

    def after_step(self, out: GvgOutput, stamp_ns: int) -> None:
        """Answer the goal under way if this step ended it, else say now and then how far it has come."""
        if self._handle is None or self._server.next_goal is not None:
            return  # what ended was not the goal that has yet to begin
        if out.dropped:
            self._node.get_logger().warning(f"goal dropped: {out.dropped}")
            self._finish(success=False, message=out.dropped, event=0)
            return
        ended = next((e for e in out.events if e.kind in (EventKind.ARRIVAL, EventKind.LOST)), None)
        if ended is not None:
            arrived = ended.kind is EventKind.ARRIVAL
            self._finish(success=arrived, message="arrived" if arrived else "lost", event=ended.sequence)
        elif out.state is GvgState.IDLE:
            self._finish(success=True, message="there", event=0)
        elif stamp_ns >= self._next_feedback_ns:
            self._next_feedback_ns = stamp_ns + _FEEDBACK_NS
            progress = self._offer.progress(self._server)
            self._handle.publish_feedback(self._offer.kind.Feedback(state=out.state.value, **progress))

    def _on_request(self, to_goal: Callable[[Any], GvgGoal], request: Any) -> GoalResponse:
        """Take the goal at once: its acceptance tells the sender in which cycle it will begin.

        One sent again, because the first answer was lost, is the goal under way: it may have left its node by now.
        """
        if self._handle is not None and stamp_from_msg(request.decided) and request == self._handle.request:
            return GoalResponse.ACCEPT
        try:
            self._server.start(to_goal(request), stamp_from_msg(request.decided) or None)
        except GvgError as error:
            self._node.get_logger().warning(f"goal refused: {error}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _on_accepted(self, offer: _Offer, handle: Any) -> None:
        if self._handle is not None:
            self._finish(success=False, message="a new goal took its place", event=0)
        self._offer, self._handle = offer, handle

    def _on_cancel(self, _: Any) -> CancelResponse:
        self._server.start(GvgGoal(GoalKind.STOP))
        return CancelResponse.ACCEPT

    def _finish(self, *, success: bool, message: str, event: int) -> None:
        handle, self._handle = self._handle, None
        self._results[bytes(handle.goal_id.uuid)] = success, message, event
        handle.execute()

    def _on_end(self, kind: Any, handle: Any) -> Any:
        success, message, event = self._results.pop(bytes(handle.goal_id.uuid))
        if handle.is_cancel_requested:
            handle.canceled()
            success, message = False, "cancelled"
        elif success:
            handle.succeed()
        else:
            handle.abort()
        return kind.Result(success=success, message=message, event=event)
