"""The atlas as a node: hears events, edge-maps and links, says the graph, and drives the exploration."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from hslam_msgs.msg import Atlas, EdgeMap, FrameLink, GvgEvent, NodeStatus
from hslam_msgs.srv import AtlasFile, IdentifyNode
from rclpy.node import Node
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from hslam_atlas.atlas_messages import atlas_to_markers, atlas_to_msg, edge_in_map_to_msg
from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import StoreError
from hslam_atlas.explore_action import ExploreAction, out_of_reach
from hslam_atlas.gvg_client import GvgClient
from hslam_atlas.picture import node_poses
from hslam_atlas.server import AtlasOutput, AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_ros import conversions
from hslam_ros.door import Door, stamped
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE, EVENTS, LATCHED
from hslam_ros.spin import run
from hslam_ros.stamps import NS_PER_S
from hslam_ros.step_order import Cycle, StepOrder
from hslam_types import edge_map, gvg_events
from hslam_types.answer import Answer
from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2


@dataclass(frozen=True)
class AtlasNodeConfig(Configuration):
    """How the node is joined to the others, and where the atlas is kept."""

    lockstep: bool = parameter(True, "wait for every input of a cycle however long it takes")
    hold_back_s: float = parameter(
        0.5, "running free: how long a cycle waits for late events and maps", low=0.0, high=5.0, unit="s"
    )
    store: str = parameter("", "atlas file to take up and keep writing; empty: in memory only")
    gvg: str = parameter("gvg", "node whose events are heard and whose actions are used")
    ekf: str = parameter("ekf", "node whose edge-maps and links are heard")


class AtlasNode(Node):
    """Puts inputs in order of stamp, hands each cycle to the server, passes goals on, publishes the graph."""

    def __init__(self) -> None:
        """Declare parameters, topics, services and actions; raises HslamError on a bad parameter or atlas file."""
        super().__init__("atlas")
        self._config = declare(self, AtlasNodeConfig)
        atlas_config = declare(self, AtlasConfig)
        self._store = AtlasStore(Path(self._config.store) if self._config.store else None)
        self._server = AtlasServer(atlas_config, self._store)
        hold_ns = None if self._config.lockstep else round(self._config.hold_back_s * NS_PER_S)
        promised = {"events": EVENTS.depth, "maps": EVENTS.depth}
        self._order = StepOrder(promised=promised, hold_ns=hold_ns, take_up=not self._server.state.graph.nodes)
        self._door = Door(self)
        self._cycles: list[Cycle] = []
        self._deciding = False
        self._outputs = 0
        self._poses: dict[int, SE2] = {}  # the nodes' in map, composed when the atlas changes
        self._gvg = GvgClient(self, self._config.gvg)
        self._create_topics()
        self.create_service(AtlasFile, "~/save", self._on_save)
        self.create_service(AtlasFile, "~/load", self._on_load)
        self.create_service(IdentifyNode, "~/identify", self._on_identify)
        self._explore = ExploreAction(self, lambda: self._server)

    def close(self) -> None:
        """Close the atlas file."""
        self._store.close()

    def _create_topics(self) -> None:
        gvg, ekf = self._config.gvg, self._config.ekf
        self._atlas = self.create_publisher(Atlas, "~/atlas", LATCHED)
        self._markers = self.create_publisher(MarkerArray, "~/markers", LATCHED)
        self._tf = self.create_publisher(TFMessage, "/tf_static", LATCHED)  # holds from one event to the next
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)
        for kind, topic, convert, stream in (
            (GvgEvent, f"{gvg}/events", conversions.event_from_msg, "events"),
            (EdgeMap, f"{ekf}/edge_maps", conversions.edge_map_from_msg, "maps"),
            (FrameLink, f"{ekf}/frame_links", conversions.link_from_msg, "maps"),
        ):
            take, refused = partial(self._on_input, stream), partial(self._on_refused, stream)
            self._door.hear(kind, topic, stamped(convert), take, EVENTS, refused)
        self._door.hear(NodeStatus, f"{gvg}/status", conversions.answer_from_msg, self._on_gvg_answer, CYCLE)
        self._door.hear(NodeStatus, f"{ekf}/status", conversions.answer_from_msg, self._on_ekf_answer, CYCLE)

    def _on_input(self, stream: str, said: tuple[int, Any]) -> None:
        self._order.put(stream, *said)
        self._work()

    def _on_refused(self, stream: str, stamp_ns: int | None) -> None:
        self._order.miss(stream, stamp_ns)
        self._work()

    def _on_gvg_answer(self, answer: Answer) -> None:
        self._order.promise("events", answer.stamp_ns, answer.outputs)
        self._order.tick(answer.stamp_ns)  # GVG's answer to a cycle opens the atlas's
        self._work()

    def _on_ekf_answer(self, answer: Answer) -> None:
        self._order.promise("maps", answer.stamp_ns, answer.outputs)
        self._work()

    def _work(self) -> None:
        self._cycles.extend(self._order.ready())
        while self._cycles and not self._deciding:
            self._step(self._cycles.pop(0))

    def _step(self, cycle: Cycle) -> None:
        events: tuple[gvg_events.GvgEvent, ...] = cycle.inputs["events"]
        maps = tuple(item for item in cycle.inputs["maps"] if isinstance(item, edge_map.EdgeMap))
        links = tuple(item for item in cycle.inputs["maps"] if isinstance(item, edge_map.FrameLink))
        out = self._server.step(events, maps, links)
        if out.changed:
            self._publish_graph(cycle.stamp_ns)
        if events:
            self._publish_frame(cycle.stamp_ns)
        if out.goal is None:
            self._answer(cycle.stamp_ns, out)
            return
        if out.finished and self._server.unexplored:
            self.get_logger().warning(f"exploration ends, {out_of_reach(self._server.unexplored)}")
        # The cycle is answered once the goal is taken: in lock-step the cycle that begins it must not come before.
        self._deciding = True
        self._gvg.send(
            out.goal, cycle.stamp_ns, lambda accepted: self._on_goal_answer(cycle.stamp_ns, out, accepted=accepted)
        )

    def _on_goal_answer(self, stamp_ns: int, out: AtlasOutput, *, accepted: bool) -> None:
        if not accepted:
            self.get_logger().error(f"GVG refused the goal {out.goal}")
            self._server.refused()
        self._outputs += 1
        self._deciding = False
        self._answer(stamp_ns, out)
        self._work()

    def _answer(self, stamp_ns: int, out: AtlasOutput) -> None:
        graph = self._server.state.graph
        status = NodeStatus(header=conversions.header(stamp_ns, ""), node=self.get_name(), outputs=self._outputs)
        left = self._server.unexplored
        status.detail = f"{len(graph.nodes)} nodes, {len(graph.edges)} edges, {left} unexplored"
        if out.finished:
            status.state = "stopped" if left else "explored"
            status.detail += " and out of reach" if left else ""
        else:
            status.state = "exploring" if self._server.exploring else "mapping"
        status.finished = out.finished
        status.detail += f"; {self._door.report()}" if self._door.refused else ""
        self._status.publish(status)
        self._explore.after_step(out)

    def _publish_graph(self, stamp_ns: int) -> None:
        self._poses = node_poses(self._server.state.graph)
        self._atlas.publish(atlas_to_msg(self._server, self._poses, stamp_ns))
        if self._markers.get_subscription_count():
            self._markers.publish(atlas_to_markers(self._server, self._poses, stamp_ns))

    def _publish_frame(self, stamp_ns: int) -> None:
        transform = edge_in_map_to_msg(self._server, self._poses, stamp_ns)
        if transform is not None:
            self._tf.publish(transform)

    def _on_save(self, request: AtlasFile.Request, response: AtlasFile.Response) -> AtlasFile.Response:
        try:
            self._server.save_as(Path(request.path))
            response.success, response.message = True, f"saved to {request.path}"
        except StoreError as error:
            response.success, response.message = False, str(error)
        return response

    def _on_load(self, request: AtlasFile.Request, response: AtlasFile.Response) -> AtlasFile.Response:
        try:
            store = AtlasStore(Path(request.path), create=False)
            server = AtlasServer(self._server.state.config, store)
            server.exploring = self._server.exploring
            self._store.close()
            self._server, self._store, self._poses = server, store, {}
            response.success, response.message = True, f"loaded {request.path}; the robot has to find itself"
        except StoreError as error:
            response.success, response.message = False, str(error)
        return response

    def _on_identify(self, request: IdentifyNode.Request, response: IdentifyNode.Response) -> IdentifyNode.Response:
        response.success = self._server.identify(request.node)
        response.message = "taken" if response.success else "the map contradicts, or that node was never suspected"
        return response


def main() -> None:
    """Run the node until a signal."""
    run(AtlasNode)
