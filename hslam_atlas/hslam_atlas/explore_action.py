"""The mission as a ROS action: one goal at a time, a new one takes the place of the last."""

from collections.abc import Callable
from functools import partial
from typing import Any

from hslam_msgs.action import Explore
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node

from hslam_atlas.server import AtlasOutput, AtlasServer


class ExploreAction:
    """Takes up the mission for a client and answers when it has ended, whichever way."""

    def __init__(self, node: Node, server: Callable[[], AtlasServer]) -> None:
        """Offer the action on ``node``; ``server`` gives the present server."""
        self._server = server
        self._handle: Any = None
        self._action = ActionServer(
            node,
            Explore,
            "~/explore",
            _answer,
            handle_accepted_callback=self._on_accepted,
            cancel_callback=self._on_cancel,
        )

    def after_step(self, out: AtlasOutput) -> None:
        """Answer the goal under way if the mission has ended."""
        server = self._server()
        if out.finished:
            left = server.unexplored
            self._end(success=not left, message=out_of_reach(left) if left else "no branch is left unexplored")
        elif not server.exploring:
            self._end(success=False, message="stopped")

    def _on_accepted(self, handle: Any) -> None:
        self._end(success=False, message="a new goal took its place")
        self._handle = handle
        self._server().explore()

    def _on_cancel(self, _: Any) -> CancelResponse:
        self._server().stop()
        return CancelResponse.ACCEPT

    def _end(self, *, success: bool, message: str) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            handle.execute(partial(_answer, success=success, message=message))


def out_of_reach(branches: int) -> str:
    """Say what an exploration that ended has not explored."""
    return f"unexplored branches left out of reach: {branches}"


def _answer(handle: Any, *, success: bool = False, message: str = "") -> Explore.Result:
    if handle.is_cancel_requested:
        handle.canceled()
    elif success:
        handle.succeed()
    else:
        handle.abort()
    return Explore.Result(success=success, message=message)
