"""The atlas as a node: hears events, edge-maps and links, says the graph, and drives the exploration."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from hslam_msgs.msg import EdgeMap, FrameLink, GvgEvent, NodeStatus
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from hslam_atlas.atlas_in_use import AtlasInUse
from hslam_atlas.atlas_picture import AtlasPicture
from hslam_atlas.atlas_services import AtlasServices
from hslam_atlas.atlas_status import diagnostics_to_msg, status_of
from hslam_atlas.config import AtlasConfig
from hslam_atlas.errand_topics import ErrandTopics
from hslam_atlas.gvg_client import GvgClient
from hslam_atlas.inbox import Inbox, Met
from hslam_atlas.mission_actions import MissionActions, out_of_reach
from hslam_atlas.robot_sense import RobotSense, unmapped
from hslam_atlas.server import AtlasOutput, AtlasServer
from hslam_ros import conversions
from hslam_ros.door import Door, stamped
from hslam_ros.parameters import declare, follow
from hslam_ros.qos import CYCLE, EVENTS
from hslam_ros.spin import run
from hslam_ros.stamps import NS_PER_S
from hslam_ros.step_order import TIME, Cycle, StepOrder
from hslam_types.answer import Answer
from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2

_SAVE_AGAIN_S = 1.0
"""How often it is tried again to write an atlas that could not be written."""


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
        self._in_use = AtlasInUse(atlas_config, Path(self._config.store) if self._config.store else None)
        hold_ns = None if self._config.lockstep else round(self._config.hold_back_s * NS_PER_S)
        promised = {"events": EVENTS.depth, "maps": EVENTS.depth}
        self._order = StepOrder(promised=promised, hold_ns=hold_ns, take_up=not self._server.state.graph.nodes)
        self._inbox = Inbox(waits=not self._config.lockstep)
        self._door = Door(self)
        self._cycles: list[Cycle] = []
        self._deciding = False
        self._outputs = self._stamp_ns = 0
        self._gvg = GvgClient(self, self._config.gvg)
        self._sense = RobotSense(self, self._config.ekf)
        self._create_topics()
        self._picture = AtlasPicture(self, self._in_use)
        self._asked = AtlasServices(self, self._in_use, self._picture.show_other_graph, self._base_in_map)
        self._actions = MissionActions(self, lambda: self._server, self._base_in_map)
        self._errands = ErrandTopics(self, self._door, lambda: self._server, self._actions.supersede)
        follow(self, AtlasConfig, atlas_config, self._on_config)
        self._unsaved: str | None = None
        self.create_timer(_SAVE_AGAIN_S, self._look_after, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @property
    def _server(self) -> AtlasServer:
        return self._in_use.server

    def close(self) -> None:
        """Close the atlas file; raises StoreError if the newest of the atlas cannot be saved."""
        self._in_use.close()

    def _create_topics(self) -> None:
        gvg, ekf = self._config.gvg, self._config.ekf
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
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
        self._sense.hear_gvg(answer)
        self._order.promise("events", answer.stamp_ns, answer.outputs)
        self._order.tick(answer.stamp_ns)  # GVG's answer to a cycle opens the atlas's
        self._work()

    def _on_ekf_answer(self, answer: Answer) -> None:
        self._sense.hear_ekf(answer)
        self._inbox.hear(answer)
        self._order.promise("maps", answer.stamp_ns, answer.outputs)
        self._work()

    def _work(self) -> None:
        self._cycles.extend(self._order.ready())
        while self._cycles and not self._deciding:
            self._step(self._cycles.pop(0))

    def _step(self, cycle: Cycle) -> None:
        for stream, what in cycle.anew.items():
            self.get_logger().warning(f"{stream}: {what}")
        if cycle.anew.keys() & {TIME, "events"}:
            self._server.lose()
            self._inbox.clear()
        inputs = cycle.inputs
        met = self._inbox.take(cycle.stamp_ns, inputs["events"], inputs["maps"], cycle.complete_ns["maps"])
        for line in self._inbox.news():
            self.get_logger().warning(line)
        arrival = unmapped(met.events, met.edge_maps) if self._server.dispatch.locator is not None else None
        if arrival is None:
            self._decide(cycle.stamp_ns, met)
            return
        self._deciding = True  # what was seen on the way there says where it is
        self._sense.wait_for_map(arrival, lambda: self._go_on(partial(self._decide, cycle.stamp_ns, met)))

    def _go_on(self, deferred: Callable[[], None]) -> None:
        self._deciding = False
        deferred()
        self._work()

    def _decide(self, stamp_ns: int, met: Met) -> None:
        sense = self._sense.at(stamp_ns)
        out = self._server.step(met.events, met.edge_maps, met.links, sense)
        self._tell_of_saving()
        if out.changed:
            self._picture.show_graph(stamp_ns)
        if met.events:
            self._picture.show_frame(sense.traversal, stamp_ns)
        if out.goal is None:
            self._answer(stamp_ns, out)
            return
        if out.finished and self._server.unexplored:
            self.get_logger().warning(f"exploration ends, {out_of_reach(self._server.unexplored)}")
        # The cycle is answered once the goal is taken: in lock-step the cycle that begins it must not come before.
        self._deciding = True
        self._gvg.send(out.goal, stamp_ns, lambda accepted: self._on_goal_answer(stamp_ns, out, accepted=accepted))

    def _on_goal_answer(self, stamp_ns: int, out: AtlasOutput, *, accepted: bool) -> None:
        if not accepted:
            self.get_logger().error(f"GVG refused the goal {out.goal}")
            self._server.refused()
        self._outputs += 1
        self._deciding = False
        self._answer(stamp_ns, out)
        self._work()

    def _answer(self, stamp_ns: int, out: AtlasOutput) -> None:
        status = status_of(self._server, out, stamp_ns)
        status.node, status.outputs = self.get_name(), self._outputs
        for more in (self._door.report(), self._inbox.awaited(stamp_ns)):
            status.detail += f"; {more}" if more else ""
        self._status.publish(status)
        self._stamp_ns = stamp_ns
        self._actions.after_step(out, stamp_ns)

    def _base_in_map(self) -> SE2 | None:
        return self._server.dispatch.base_in_map()

    def _on_config(self, config: AtlasConfig) -> None:
        self._actions.supersede()
        self._in_use.change(config)

    def _look_after(self) -> None:
        """Do what is due now and then: save what could not be, say whether the robot's place is known."""
        self._sense.look()
        self._diagnostics.publish(diagnostics_to_msg(self._server, self._inbox, self._stamp_ns))
        if self._server.unsaved is not None:
            self._server.try_to_save()
        self._tell_of_saving()

    def _tell_of_saving(self) -> None:
        """Say once that the atlas cannot be saved, and once that it is."""
        why, before = self._server.unsaved, self._unsaved
        if why is not None and before is None:
            self.get_logger().error(f"{why}; the robot goes on, and it is tried again")
        if why is None and before is not None:
            self.get_logger().info("the atlas is saved again")
        self._unsaved = why


def main() -> None:
    """Run the node until a signal."""
    run(AtlasNode)
