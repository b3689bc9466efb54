"""The node against the plain server: the same atlas bit for bit, a cycle answered only when its goal is taken."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from corridor_floor import furnish, wean_hall
from edge_walker import EdgeWalker, Step, WalkNoise
from hslam_msgs.action import AccessGvg, Explore, TraceEdge
from hslam_msgs.msg import Atlas, EdgeMap, FrameLink, GvgEvent, NodeStatus
from hslam_msgs.srv import AtlasFile, IdentifyNode
from rclpy.action import ActionClient, ActionServer
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from hslam_atlas.atlas_node import AtlasNode
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_ros import conversions
from hslam_ros.qos import CYCLE, EVENTS, LATCHED
from hslam_ros.stamps import stamp_from_msg
from hslam_types.gvg_events import GoalKind, GvgGoal

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
        self._said = {"events": 0, "maps": 0}
        self._events = self.create_publisher(GvgEvent, "gvg/events", EVENTS)
        self._maps = self.create_publisher(EdgeMap, "ekf/edge_maps", EVENTS)
        self._links = self.create_publisher(FrameLink, "ekf/frame_links", EVENTS)
        self._gvg = self.create_publisher(NodeStatus, "gvg/status", CYCLE)
        self._ekf = self.create_publisher(NodeStatus, "ekf/status", CYCLE)
        self.create_subscription(NodeStatus, "atlas/status", self.statuses.append, CYCLE)
        self.create_subscription(Atlas, "atlas/atlas", self.graphs.append, LATCHED)
        self._servers: list[Any] = []

    def open_actions(self) -> None:
        """Offer what gvg offers."""
        for kind, name, to_goal in (
            (AccessGvg, "gvg/access", lambda _: GvgGoal(GoalKind.ACCESS)),
            (TraceEdge, "gvg/trace", lambda goal: GvgGoal(GoalKind.TRACE, branch=int(goal.branch))),
        ):
            self._servers.append(
                ActionServer(
                    self, kind, name, self._end, handle_accepted_callback=lambda h, f=to_goal: self._take(h, f)
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
        for edge_map in maps:
            self._maps.publish(conversions.edge_map_to_msg(edge_map, stamp_ns))
        for link in links:
            self._links.publish(conversions.link_to_msg(link, stamp_ns))
        for event in events:
            self._events.publish(conversions.event_to_msg(event))

    def _take(self, handle: Any, to_goal: Callable[[Any], GvgGoal]) -> None:
        self.goals.append(to_goal(handle.request))

    def _end(self, handle: Any) -> Any:
        handle.succeed()
        return AccessGvg.Result()


class Pair:
    """The node and the rest of the suite on one executor."""

    def __init__(self) -> None:
        self.atlas, self.rest = AtlasNode(), Rest()
        self._executor = EventsExecutor()
        self._executor.add_node(self.atlas)
        self._executor.add_node(self.rest)

    def spin_until(self, predicate: Callable[[], bool], timeout_s: float = 30.0) -> None:
        """Run callbacks until something holds; fails after ``timeout_s`` of wall time."""
        deadline = time.monotonic() + timeout_s
        while not predicate():
            assert time.monotonic() < deadline, "nothing came in time"
            self._executor.spin_once(timeout_sec=0.05)

    def cycle(self, stamp_ns: int, step: Step | None) -> None:
        """Say a cycle and wait for its answer."""
        answered = len(self.rest.statuses)
        self.rest.say(stamp_ns, step)
        self.spin_until(lambda: len(self.rest.statuses) > answered)

    def explore(self, goals: int) -> None:
        """Do what the node asks, up to so many goals."""
        base = walker()
        self.cycle(0, None)
        for _ in range(goals):
            for step in base.follow(self.rest.goals[-1]):
                self.cycle(step.stamp_ns, step)

    def call(self, kind: Any, name: str, request: Any) -> Any:
        """Call a service of the node."""
        client = self.rest.create_client(kind, name)
        self.spin_until(client.service_is_ready)
        future = client.call_async(request)
        self.spin_until(future.done)
        return future.result()

    def close(self) -> None:
        """End the executor, then the nodes."""
        self._executor.shutdown()
        self.atlas.close()
        self.atlas.destroy_node()
        self.rest.destroy_node()


Start = Callable[..., Pair]


@pytest.fixture
def start() -> Iterator[Start]:
    """Give a function that starts the node with parameters and the rest; everything is shut down afterwards."""
    pairs: list[Pair] = []

    def make(**parameters: object) -> Pair:
        arguments = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
        rclpy.init(args=["--ros-args", *arguments], signal_handler_options=SignalHandlerOptions.NO)
        pairs.append(Pair())
        return pairs[-1]

    yield make
    for pair in pairs:
        pair.close()
    rclpy.try_shutdown()


def test_lock_step_gives_the_atlas_of_the_plain_server(start: Start, tmp_path: Path) -> None:
    pair = start(store=tmp_path / "atlas.db")
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


def test_a_cycle_is_answered_only_when_its_goal_is_taken(start: Start) -> None:
    """In lock-step the base waits for the answer: the goal then reaches gvg before the next cycle."""
    pair = start()
    pair.rest.say(0, None)
    with pytest.raises(AssertionError, match="nothing came"):
        pair.spin_until(lambda: len(pair.rest.statuses) > 0, timeout_s=1.5)
    pair.rest.open_actions()
    pair.spin_until(lambda: len(pair.rest.statuses) > 0)
    assert [goal.kind for goal in pair.rest.goals] == [GoalKind.ACCESS]
    assert stamp_from_msg(pair.rest.statuses[0].header.stamp) == 0


def test_exploration_is_an_action_when_the_mission_is_none(start: Start) -> None:
    pair = start(mission="none")
    pair.rest.open_actions()
    pair.cycle(0, None)
    assert not pair.rest.goals
    client: Any = ActionClient(pair.rest, Explore, "atlas/explore")
    pair.spin_until(client.server_is_ready)
    sent = client.send_goal_async(Explore.Goal())
    pair.spin_until(sent.done)
    assert sent.result().accepted
    pair.cycle(1, None)
    assert [goal.kind for goal in pair.rest.goals] == [GoalKind.ACCESS]


def test_services_save_load_and_refuse(start: Start, tmp_path: Path) -> None:
    pair = start()
    pair.rest.open_actions()
    pair.explore(3)
    saved = pair.call(AtlasFile, "atlas/save", AtlasFile.Request(path=str(tmp_path / "copy.db")))
    assert saved.success
    assert (tmp_path / "copy.db").stat().st_size > 10_000
    (tmp_path / "junk.db").write_bytes(b"no atlas" * 500)
    refused = pair.call(AtlasFile, "atlas/load", AtlasFile.Request(path=str(tmp_path / "junk.db")))
    assert not refused.success
    assert "junk.db" in refused.message
    loaded = pair.call(AtlasFile, "atlas/load", AtlasFile.Request(path=str(tmp_path / "copy.db")))
    assert loaded.success
    assert not pair.call(IdentifyNode, "atlas/identify", IdentifyNode.Request(node=99)).success
