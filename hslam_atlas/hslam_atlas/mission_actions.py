"""The missions as ROS actions: one goal at a time, whichever action it is of; a new one takes the place of the last."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from hslam_msgs.action import Explore, Localise, NavigateTo
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node

from hslam_atlas.destinations import destination_from_msg
from hslam_atlas.errors import AtlasError
from hslam_atlas.missions.localise import Localise as LocaliseMission
from hslam_atlas.missions.navigate import Navigate, Progress
from hslam_atlas.server import AtlasOutput, AtlasServer
from hslam_ros.conversions import pose_to_msg
from hslam_ros.stamps import NS_PER_S
from hslam_types.se2 import SE2

_FEEDBACK_NS = NS_PER_S
_UNKNOWN = SE2(math.nan, math.nan, math.nan)


class _Offer(NamedTuple):
    """An action: how its mission begins, what is said on the way, and the result (success first) at its end."""

    kind: Any
    begin: Callable[[Any], None]
    progress: Callable[[], dict[str, Any]]
    result: Callable[[], dict[str, Any]]


class MissionActions:
    """Takes up missions for clients and answers when they have ended, whichever way."""

    def __init__(self, node: Node, server: Callable[[], AtlasServer], base_in_map: Callable[[], SE2 | None]) -> None:
        """Offer the actions on ``node``; ``server`` gives the present server, ``base_in_map`` where the robot is."""
        self._node, self._server, self._base_in_map = node, server, base_in_map
        offers = {
            "~/explore": _Offer(Explore, self._begin_exploring, self._explored, self._end_of_exploring),
            "~/navigate_to": _Offer(NavigateTo, self._begin_navigating, self._way, self._end_of_way),
            "~/localise": _Offer(Localise, self._begin_localising, self._search, self._end_of_search),
        }
        self._handle: Any = None
        self._offer = offers["~/explore"]
        self._next_feedback_ns = 0
        self._servers = [
            ActionServer(
                node,
                offer.kind,
                name,
                partial(_answer, offer.kind),
                handle_accepted_callback=partial(self._on_accepted, offer),
                cancel_callback=self._on_cancel,
            )
            for name, offer in offers.items()
        ]

    def supersede(self) -> None:
        """End the goal under way: something else is to be done now."""
        self._end({"success": False, "message": "a new goal took its place"})

    def after_step(self, out: AtlasOutput, stamp_ns: int) -> None:
        """Answer the goal under way if its mission has ended, else say now and then how far it has come."""
        if self._handle is None:
            return
        if self._server().dispatch.mission is None:
            self._end({"success": False, "message": "stopped"})
        elif out.finished:
            self._end(self._offer.result())
        elif stamp_ns >= self._next_feedback_ns:
            self._next_feedback_ns = stamp_ns + _FEEDBACK_NS
            self._handle.publish_feedback(self._offer.kind.Feedback(**self._offer.progress()))

    def _on_accepted(self, offer: _Offer, handle: Any) -> None:
        self.supersede()
        self._offer, self._handle, self._next_feedback_ns = offer, handle, 0
        try:
            offer.begin(handle.request)
        except AtlasError as error:
            result = {"success": False, "message": str(error)}
            self._end(result | ({"unreachable": True} if offer.kind is NavigateTo else {}))

    def _on_cancel(self, handle: Any) -> CancelResponse:
        if self._handle is not None and handle.goal_id == self._handle.goal_id:
            self._server().stop()
        return CancelResponse.ACCEPT

    def _begin_exploring(self, _: Explore.Goal) -> None:
        self._server().explore()

    def _explored(self) -> dict[str, Any]:
        server, graph = self._server(), self._server().state.graph
        figures = {"nodes": len(graph.nodes), "edges": len(graph.edges), "unexplored": server.unexplored}
        return figures | {"path_length": server.dispatch.path_length_m}

    def _end_of_exploring(self) -> dict[str, Any]:
        left = self._server().unexplored
        return {"success": not left, "message": out_of_reach(left) if left else "no branch is left unexplored"}

    def _begin_navigating(self, goal: NavigateTo.Goal) -> None:
        server, base = self._server(), self._base_in_map()
        here = None if base is None else (base.x, base.y)
        server.dispatch.navigate(destination_from_msg(goal.destination, server.state, server.store.places(), here))

    def _way(self) -> dict[str, Any]:
        dispatch = self._server().dispatch
        mission, node = dispatch.now, dispatch.about()
        left_m = mission.path_left_m if isinstance(mission, Navigate) else math.nan
        return {"state": dispatch.doing, "node": -1 if node is None else node, "path_left": left_m}

    def _end_of_way(self) -> dict[str, Any]:
        mission = self._server().dispatch.now
        if not isinstance(mission, Navigate):
            return {"success": False, "message": "stopped"}
        reached = mission.progress is Progress.REACHED
        return {"success": reached, "unreachable": not reached, "message": "there" if reached else mission.why}

    def _begin_localising(self, goal: Localise.Goal) -> None:
        if not self._server().state.graph.edges:
            raise AtlasError("the atlas has no edges: there is nothing to find the robot in")
        self._server().dispatch.localise(anew=goal.anew)

    def _search(self) -> dict[str, Any]:
        dispatch = self._server().dispatch
        locator, mission = dispatch.locator, dispatch.now
        drives = mission.drives if isinstance(mission, LocaliseMission) else 0
        return {"state": dispatch.doing, "places": 0 if locator is None else len(locator.places), "drives": drives}

    def _end_of_search(self) -> dict[str, Any]:
        node = self._server().dispatch.about()
        if node is None:
            return {"success": False, "message": "no place of the atlas explains what was seen"}
        pose = pose_to_msg(self._base_in_map() or _UNKNOWN)
        return {"success": True, "message": f"at node {node}", "node": node, "base_in_map": pose}

    def _end(self, result: dict[str, Any]) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            handle.execute(partial(_answer, self._offer.kind, result=result))


def out_of_reach(branches: int) -> str:
    """Say what an exploration that ended has not explored."""
    return f"unexplored branches left out of reach: {branches}"


def _answer(kind: Any, handle: Any, *, result: dict[str, Any] | None = None) -> Any:
    result = result or {"success": False, "message": ""}
    if handle.is_cancel_requested:
        handle.canceled()
    elif result["success"]:
        handle.succeed()
    else:
        handle.abort()
    return kind.Result(**result)
