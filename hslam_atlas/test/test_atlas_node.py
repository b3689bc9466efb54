"""The node against the plain server: the same atlas bit for bit, a cycle answered only when its goal is taken."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from corridor_floor import furnish, wean_hall
from edge_walker import EdgeWalker, Step, WalkNoise
from hslam_msgs.action import AccessGvg, Explore, TraceEdge
from hslam_msgs.msg import Atlas, EdgeMap, FrameLink, GvgEvent, NodeStatus
from hslam_msgs.srv import AtlasFile, IdentifyNode
from rclpy.action import ActionClient, ActionServer, GoalResponse
from rclpy.node import Node
from ros_stage import Stage, Staged
from tf2_msgs.msg import TFMessage

from hslam_atlas.atlas_node import AtlasNode
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_atlas.whereabouts import Here
from hslam_ros import conversions
from hslam_ros.qos import CYCLE, EVENTS, LATCHED
from hslam_ros.stamps import stamp_from_msg
from hslam_types import edge_map, gvg_events
from hslam_types.gvg_events import GoalKind, GvgGoal, NodeKind
from hslam_types.se2 import SE2

GOALS = 6


def walker() -> EdgeWalker:
    floor = furnish(wean_hall(), np.random.default_rng(1000))
    return EdgeWalker(floor, 0, np.random.default_rng(0), WalkNoise())


class Rest(Node):
    """gvg and ekf in one: takes goals, says what a walker answers, keeps what the atlas says."""

    def __init__(self) -> None:
        super().__init__("rest")
        self.goals: list[GvgGoal] = []
        self.statuses: list[NodeStatus] = []
        self.graphs: list[Atlas] = []
        self.transforms: list[TFMessage] = []
        self._said = {"events": 0, "maps": 0}
        self._events = self.create_publisher(GvgEvent, "gvg/events", EVENTS)
        self._maps = self.create_publisher(EdgeMap, "ekf/edge_maps", EVENTS)
        self._links = self.create_publisher(FrameLink, "ekf/frame_links", EVENTS)
        self._gvg = self.create_publisher(NodeStatus, "gvg/status", CYCLE)
        self._ekf = self.create_publisher(NodeStatus, "ekf/status", CYCLE)
        self.create_subscription(NodeStatus, "atlas/status", self.statuses.append, CYCLE)
        self.create_subscription(Atlas, "atlas/atlas", self.graphs.append, LATCHED)
        self.create_subscription(TFMessage, "/tf_static", self.transforms.append, LATCHED)
        self._servers: list[Any] = []
        self.refuse = 0
        """How many goals to refuse."""

    def open_actions(self) -> None:
        """Offer what gvg offers."""
        for kind, name, to_goal in (
            (AccessGvg, "gvg/access", lambda _: GvgGoal(GoalKind.ACCESS)),
            (TraceEdge, "gvg/trace", lambda goal: GvgGoal(GoalKind.TRACE, branch=int(goal.branch))),
        ):
            self._servers.append(
                ActionServer(
                    self,
                    kind,
                    name,
                    self._end,
                    goal_callback=self._judge,
                    handle_accepted_callback=lambda h, f=to_goal: self._take(h, f),
                )
            )

    def say(self, stamp_ns: int, step: Step | None) -> None:
        """Publish one cycle, the statuses first: the listener has to wait for what they promise."""
        events, maps, links = (step.events, step.edge_maps, step.links) if step else ((), (), ())
        self._said["events"] += len(events)
        self._said["maps"] += len(maps) + len(links)
        about = conversions.header(stamp_ns, "")
        self._gvg.publish(NodeStatus(header=about, node="gvg", outputs=self._said["events"]))
        self._ekf.publish(NodeStatus(header=about, node="ekf", outputs=self._said["maps"]))
        self._publish(stamp_ns, maps, links)
        for event in events:
            self._events.publish(conversions.event_to_msg(event))

    def say_gvg(self, stamp_ns: int, events: tuple[gvg_events.GvgEvent, ...] = ()) -> None:
        """Publish gvg's part of a cycle alone."""
        self._said["events"] += len(events)
        for event in events:
            self._events.publish(conversions.event_to_msg(event))
        self._gvg.publish(NodeStatus(header=conversions.header(stamp_ns, ""), outputs=self._said["events"]))

    def say_ekf(self, stamp_ns: int, step: Step | None, next_event: int) -> None:
        """Publish ekf's part of a cycle alone."""
        maps, links = (step.edge_maps, step.links) if step else ((), ())
        self._said["maps"] += len(maps) + len(links)
        self._publish(stamp_ns, maps, links)
        about = conversions.header(stamp_ns, "")
        self._ekf.publish(NodeStatus(header=about, outputs=self._said["maps"], next_event=next_event))

    def _publish(
        self, stamp_ns: int, maps: tuple[edge_map.EdgeMap, ...], links: tuple[edge_map.FrameLink, ...]
    ) -> None:
        for each in maps:
            self._maps.publish(conversions.edge_map_to_msg(each, stamp_ns))
        for link in links:
            self._links.publish(conversions.link_to_msg(link, stamp_ns))

    def was_placed(self, stamp_ns: int) -> bool:
        """Whether the newest transform is of a cycle."""
        return bool(self.transforms) and stamp_from_msg(self.transforms[-1].transforms[0].header.stamp) == stamp_ns

    def _judge(self, _: Any) -> GoalResponse:
        self.refuse -= 1
        return GoalResponse.REJECT if self.refuse >= 0 else GoalResponse.ACCEPT

    def _take(self, handle: Any, to_goal: Callable[[Any], GvgGoal]) -> None:
        self.goals.append(to_goal(handle.request))

    def _end(self, handle: Any) -> Any:
        handle.succeed()
        return AccessGvg.Result()


class Pair(Stage):
    """The node and the rest of the suite."""

    def __init__(self, **parameters: object) -> None:
        super().__init__(**parameters)
        self.atlas, self.rest = self.add(AtlasNode()), self.add(Rest())
        self._clients: list[Any] = []

    def cycle(self, stamp_ns: int, step: Step | None) -> None:
        """Say a cycle and wait for its answer."""
        answered = len(self.rest.statuses)
        self.rest.say(stamp_ns, step)
        self.spin_until(lambda: len(self.rest.statuses) > answered)

    def answered(self, stamp_ns: int) -> bool:
        """Whether the node has answered a cycle, or a later one."""
        return any(stamp_from_msg(status.header.stamp) >= stamp_ns for status in self.rest.statuses)

    def explore(self, goals: int) -> None:
        """Do what the node asks, up to so many goals."""
        base = walker()
        self.cycle(0, None)
        for _ in range(goals):
            for step in base.follow(self.rest.goals[-1]):
                self.cycle(step.stamp_ns, step)

    def ask_to_explore(self) -> Any:
        """Send the node the goal to explore; return the client's handle."""
        client: Any = ActionClient(self.rest, Explore, "atlas/explore")
        self._clients.append(client)
        self.spin_until(client.server_is_ready)
        handle = self.wait(client.send_goal_async(Explore.Goal()))
        assert handle.accepted
        return handle

    def result_of(self, handle: Any) -> Any:
        """Wait for the answer to a goal: its status and result."""
        return self.wait(handle.get_result_async())


def test_lock_step_gives_the_atlas_of_the_plain_server(staged: Staged, tmp_path: Path) -> None:
    pair = staged(Pair, store=tmp_path / "atlas.db")
    pair.rest.open_actions()
    pair.explore(GOALS)
    plain, base = AtlasServer(), walker()
    goal = plain.step((), (), ()).goal
    asked: list[GvgGoal] = []
    while goal is not None and len(asked) <= GOALS:
        asked.append(goal)
        if len(asked) <= GOALS:
            for step in base.follow(goal):
                goal = plain.step(step.events, step.edge_maps, step.links).goal
    with AtlasStore(tmp_path / "atlas.db") as written:
        assert list(written.dump()) == list(plain.store.dump())
    assert [(goal.kind, goal.branch) for goal in pair.rest.goals] == [(goal.kind, goal.branch) for goal in asked]
    nodes = len(plain.state.graph.nodes)
    pair.spin_until(lambda: len(pair.rest.graphs) > 0 and len(pair.rest.graphs[-1].nodes) == nodes)
    assert pair.rest.statuses[-1].outputs == GOALS + 1
    graph = pair.rest.graphs[-1]
    assert {edge.id for edge in graph.edges} == {e for node in graph.nodes for e in node.edges if e >= 0}
    first = graph.edges[0]
    assert graph.nodes[first.from_node].edges[first.from_branch] == first.id


def test_a_cycle_is_answered_only_when_its_goal_is_taken(staged: Staged) -> None:
    """In lock-step the base waits for the answer: the goal then reaches gvg before the next cycle."""
    pair = staged(Pair)
    pair.rest.say(0, None)
    with pytest.raises(AssertionError, match="nothing came"):
        pair.spin_until(lambda: len(pair.rest.statuses) > 0, timeout_s=1.5)
    pair.rest.open_actions()
    pair.spin_until(lambda: len(pair.rest.statuses) > 0)
    assert [goal.kind for goal in pair.rest.goals] == [GoalKind.ACCESS]
    assert stamp_from_msg(pair.rest.statuses[0].header.stamp) == 0


def test_the_chain_of_frames_leads_to_the_drawn_nodes(staged: Staged) -> None:
    """At a departure the edge's frame starts at the node left; at the arrival its terminal is the node come to."""
    pair = staged(Pair)
    pair.rest.open_actions()
    pair.cycle(0, None)
    base = walker()
    (_, found) = base.follow(pair.rest.goals[-1])
    pair.cycle(found.stamp_ns, found)
    for _ in range(3):
        departure, arrival = base.follow(pair.rest.goals[-1])
        edge_map = arrival.edge_maps[0]
        for step, on_x in ((departure, 0.0), (arrival, edge_map.terminal_x)):
            pair.cycle(step.stamp_ns, step)
            pair.spin_until(partial(pair.rest.was_placed, step.stamp_ns))
            (transform,) = pair.rest.transforms[-1].transforms
            assert (transform.header.frame_id, transform.child_frame_id) == ("map", f"edge_{edge_map.traversal}")
            edge_in_map = SE2(
                transform.transform.translation.x,
                transform.transform.translation.y,
                conversions.yaw_from_quaternion(transform.transform.rotation),
            )
            pair.spin_until(lambda: len(pair.rest.graphs) > 0)
            drawn = [(node.position.x, node.position.y) for node in pair.rest.graphs[-1].nodes]
            assert min(math.dist(edge_in_map.apply(on_x, 0.0), node) for node in drawn) < 0.15


def test_exploration_is_an_action_when_the_mission_is_none(staged: Staged) -> None:
    pair = staged(Pair, mission="none")
    pair.rest.open_actions()
    pair.cycle(0, None)
    assert not pair.rest.goals
    pair.ask_to_explore()
    pair.cycle(1, None)
    assert [goal.kind for goal in pair.rest.goals] == [GoalKind.ACCESS]


def test_a_second_client_takes_the_place_of_the_first_and_may_stop_the_exploration(staged: Staged) -> None:
    pair = staged(Pair, mission="none")
    pair.rest.open_actions()
    first = pair.ask_to_explore()
    second = pair.ask_to_explore()
    answer = pair.result_of(first)
    assert (answer.status, answer.result.success) == (GoalStatus.STATUS_ABORTED, False)
    assert "took its place" in answer.result.message
    pair.cycle(0, None)
    assert [goal.kind for goal in pair.rest.goals] == [GoalKind.ACCESS]
    pair.wait(second.cancel_goal_async())
    for step in walker().follow(pair.rest.goals[-1]):
        pair.cycle(step.stamp_ns, step)
    assert pair.result_of(second).status == GoalStatus.STATUS_CANCELED
    assert len(pair.rest.goals) == 1
    assert pair.rest.statuses[-1].state == "stopped"


def test_a_refused_goal_does_not_end_the_mission(staged: Staged) -> None:
    pair = staged(Pair)
    pair.rest.refuse = 2
    pair.rest.open_actions()
    for stamp_ns in range(3):
        pair.cycle(stamp_ns, None)
    assert [goal.kind for goal in pair.rest.goals] == [GoalKind.ACCESS]


@pytest.mark.parametrize("broken", ["time", "gvg"])
def test_where_time_or_gvg_begins_anew_the_robot_has_to_find_itself(staged: Staged, broken: str) -> None:
    """In the middle of an edge: what was under way is lost, and the GVG is asked for again."""
    pair = staged(Pair)
    pair.rest.open_actions()
    base = walker()
    pair.cycle(0, None)
    for step in base.follow(pair.rest.goals[-1]):
        pair.cycle(step.stamp_ns, step)
    departure = base.follow(pair.rest.goals[-1])[0]
    pair.cycle(departure.stamp_ns, departure)
    mapper, asked = pair.atlas._server.mapper, len(pair.rest.goals)
    assert mapper.underway is not None
    pair.rest._said["events"] = 0
    pair.cycle(1 if broken == "time" else departure.stamp_ns + 10**9, None)
    assert (pair.atlas._server.mapper.underway, pair.atlas._server.mapper.here) == (None, None)
    assert [goal.kind for goal in pair.rest.goals[asked:]] == [GoalKind.ACCESS]


def test_what_is_out_of_reach_is_told_at_the_end(staged: Staged) -> None:
    pair = staged(Pair, mission="none")
    pair.rest.open_actions()
    graph = pair.atlas._server.state.graph
    node = graph.add_node(NodeKind.BOUNDARY_POINT, 1.0, [0.0])
    pair.atlas._server.mapper.here = Here(node.id, (), None, -1, None)  # the visit does not show the branch
    pair.atlas._server.unexplored = 1
    handle = pair.ask_to_explore()
    pair.cycle(0, None)
    answer = pair.result_of(handle)
    assert not answer.result.success
    assert answer.result.message == "unexplored branches left out of reach: 1"
    status = pair.rest.statuses[-1]
    assert (status.finished, status.state) == (False, "stopped")  # whoever asked is told; the run goes on
    assert status.detail == "1 nodes, 0 edges, 1 unexplored and out of reach"


def test_services_save_load_and_refuse(staged: Staged, tmp_path: Path) -> None:
    pair = staged(Pair)
    pair.rest.open_actions()
    pair.explore(3)
    saved = pair.call(pair.rest, AtlasFile, "atlas/save", AtlasFile.Request(path=str(tmp_path / "copy.db")))
    assert saved.success
    assert (tmp_path / "copy.db").stat().st_size > 10_000
    (tmp_path / "junk.db").write_bytes(b"no atlas" * 500)
    refused = pair.call(pair.rest, AtlasFile, "atlas/load", AtlasFile.Request(path=str(tmp_path / "junk.db")))
    assert not refused.success
    assert "junk.db" in refused.message
    absent = pair.call(pair.rest, AtlasFile, "atlas/load", AtlasFile.Request(path=str(tmp_path / "absent.db")))
    assert not absent.success
    assert "no such file" in absent.message
    assert not (tmp_path / "absent.db").exists()
    assert pair.atlas._server.state.graph.nodes
    loaded = pair.call(pair.rest, AtlasFile, "atlas/load", AtlasFile.Request(path=str(tmp_path / "copy.db")))
    assert loaded.success
    assert not pair.call(pair.rest, IdentifyNode, "atlas/identify", IdentifyNode.Request(node=99)).success


def test_what_is_refused_is_counted_as_come_and_told(staged: Staged) -> None:
    """A map whose covariance is none leaves the arrival without one: the node found is one of its own."""
    pair = staged(Pair, mission="none")
    base = walker()
    for step in base.follow(GvgGoal(GoalKind.ACCESS)):
        pair.cycle(step.stamp_ns, step)
    departure, arrival = base.follow(GvgGoal(GoalKind.TRACE, branch=0))
    pair.cycle(departure.stamp_ns, departure)
    (edge_map,) = arrival.edge_maps
    broken = replace(edge_map, covariance=np.full_like(edge_map.covariance, np.nan))
    pair.cycle(arrival.stamp_ns, replace(arrival, edge_maps=(broken,)))
    graph = pair.atlas._server.state.graph
    assert (len(graph.nodes), len(graph.edges)) == (2, 0)
    assert pair.rest.statuses[-1].detail.endswith("; refused messages: ekf/edge_maps 1")
