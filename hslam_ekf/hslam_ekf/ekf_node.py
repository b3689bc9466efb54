"""The EKF level as a node: hears odometry, landmarks and GVG events, says edge-maps, links and the pose in the edge."""

from dataclasses import dataclass
from functools import partial

from geometry_msgs.msg import PoseWithCovarianceStamped
from hslam_msgs.msg import EdgeMap, FrameLink, GvgEvent, LandmarkObservations, NodeStatus
from hslam_msgs.srv import MapSoFar
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from hslam_ekf import ekf_messages
from hslam_ekf.config import EkfConfig
from hslam_ekf.map_so_far import map_so_far
from hslam_ekf.noise_report import NoiseReport, standing
from hslam_ekf.server import EkfOutput, EkfServer
from hslam_ros import conversions
from hslam_ros.continuity import Continuity
from hslam_ros.door import Door
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE, EVENTS, LATCHED, sensor_subscription
from hslam_ros.spin import run
from hslam_ros.stamps import NS_PER_S
from hslam_ros.step_order import Cycle, StepOrder
from hslam_types import gvg_events
from hslam_types.answer import Answer
from hslam_types.config import Configuration, parameter
from hslam_types.sensing import LandmarkView, OdometrySample


@dataclass(frozen=True)
class EkfNodeConfig(Configuration):
    """How the node is joined to the others, and what it shows."""

    lockstep: bool = parameter(True, "wait for every input of a cycle however long it takes")
    hold_back_s: float = parameter(
        0.3, "running free: how long a cycle waits for late landmarks and events", low=0.0, high=5.0, unit="s"
    )
    landmark_source: str = parameter(
        "sim", "lock-step: node whose status counts the looks sent; empty: take them as they come"
    )
    event_source: str = parameter("gvg", "node whose events are heard and whose status counts them")
    pose_every_s: float = parameter(
        0.3, "time between two poses and transforms; an arrival or departure is told at once", low=0.0, high=60.0,
        unit="s",
    )  # fmt: skip
    map_every_s: float = parameter(5.0, "time between two pictures of the live map", low=0.0, high=60.0, unit="s")
    ellipse_scale: float = parameter(10.0, "enlargement of the ellipses in the picture", low=1.0, high=1000.0)


class EkfNode(Node):
    """Puts inputs in order of stamp, hands each cycle to the server, publishes what comes of it."""

    def __init__(self) -> None:
        """Declare parameters, topics and services; raises ConfigurationError on a bad parameter."""
        super().__init__("ekf")
        self._config = declare(self, EkfNodeConfig)
        self._ekf_config = declare(self, EkfConfig)
        self._server = EkfServer(self._ekf_config)
        hold_ns = None if self._config.lockstep else round(self._config.hold_back_s * NS_PER_S)
        self._order = StepOrder(promised={"landmarks": CYCLE.depth, "events": EVENTS.depth}, hold_ns=hold_ns)
        self._continuity = Continuity()
        self._noise_report = NoiseReport()
        self._outputs = self._stamp_ns = self._next_event = 0
        self._next_pose_ns = self._next_map_ns = 0
        self._create_publishers()
        self._door = Door(self)
        self._create_subscriptions()
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_service(MapSoFar, "~/map_so_far", self._on_map_so_far)

    def _create_publishers(self) -> None:
        self._edge_maps = self.create_publisher(EdgeMap, "~/edge_maps", EVENTS)
        self._links = self.create_publisher(FrameLink, "~/frame_links", EVENTS)
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)
        self._pose = self.create_publisher(PoseWithCovarianceStamped, "~/pose", CYCLE)
        self._map = self.create_publisher(MarkerArray, "~/map", LATCHED)
        self._tf = self.create_publisher(TFMessage, "/tf", 100)

    def _create_subscriptions(self) -> None:
        hear, sensors, source = self._door.hear, sensor_subscription(self._config.lockstep), self._config.event_source
        hear(Odometry, "odom", conversions.odometry_from_msg, self._on_odometry, sensors, self._on_refused_odometry)
        hear(
            LandmarkObservations, "landmarks", conversions.landmarks_from_msg, self._on_landmarks, sensors,
            partial(self._on_refused, "landmarks"),
        )  # fmt: skip
        refused_event = partial(self._on_refused, "events")
        hear(GvgEvent, f"{source}/events", conversions.event_from_msg, self._on_event, EVENTS, refused_event)
        for stream, promiser in (("events", source), ("landmarks", self._config.landmark_source)):
            if promiser:
                promise = partial(self._on_answer, stream)
                hear(NodeStatus, f"{promiser}/status", conversions.answer_from_msg, promise, CYCLE)

    def _on_odometry(self, sample: OdometrySample) -> None:
        self._order.tick(sample.stamp_ns, sample)
        if not self._config.landmark_source:
            self._order.promise("landmarks", sample.stamp_ns, 0)
        self._work()

    def _on_refused_odometry(self, stamp_ns: int | None) -> None:
        self._order.skip(stamp_ns)
        self._work()

    def _on_landmarks(self, view: LandmarkView) -> None:
        self._order.put("landmarks", view.stamp_ns, view)
        self._work()

    def _on_event(self, event: gvg_events.GvgEvent) -> None:
        self._order.put("events", event.stamp_ns, event)
        self._work()

    def _on_refused(self, stream: str, stamp_ns: int | None) -> None:
        self._order.miss(stream, stamp_ns)
        self._work()

    def _on_answer(self, stream: str, answer: Answer) -> None:
        self._order.promise(stream, answer.stamp_ns, answer.outputs)
        self._work()

    def _work(self) -> None:
        for cycle in self._order.ready():
            self._step(cycle)

    def _step(self, cycle: Cycle) -> None:
        if cycle.skipped:
            self._answer(cycle.stamp_ns, "blind", NodeStatus())
            return
        odom: OdometrySample = cycle.clock
        self._stamp_ns = odom.stamp_ns
        self._look_for_breaks(cycle)
        *late, view = cycle.inputs["landmarks"] or (None,)
        if late:
            self.get_logger().warning(f"{len(late)} late looks dropped", throttle_duration_sec=5.0)
        events = cycle.inputs["events"]
        out = self._server.step(odom, view, events)
        self._next_event = events[-1].sequence + 1 if events else self._next_event
        for line in self._noise_report.news(self._server.noise, self._server.innovations):
            self.get_logger().warning(line)
        self._publish_maps(odom, out)
        self._publish_pose(odom, out)
        traversal = self._server.traversal
        if traversal is not None and cycle.stamp_ns >= self._next_map_ns:
            self._next_map_ns = cycle.stamp_ns + round(self._config.map_every_s * NS_PER_S)
            scale = self._config.ellipse_scale
            self._map.publish(ekf_messages.map_to_msg(cycle.stamp_ns, traversal.sequence, traversal.filter, scale))

    def _look_for_breaks(self, cycle: Cycle) -> None:
        """Begin anew where time, the GVG level or odometry has: a traversal across that would be no map of anything."""
        broken = {stream: what for stream, what in cycle.anew.items() if stream != "landmarks"}
        if jumped := self._continuity.broken_by(cycle.clock):
            broken["odom"] = jumped
        if broken:
            said = "; ".join(f"{stream}: {what}" for stream, what in broken.items())
            self.get_logger().warning(f"{said}; lost, and the traversal is forgotten")
            self._forget()

    def _forget(self) -> None:
        self._server = EkfServer(self._ekf_config)
        self._next_pose_ns = self._next_map_ns = 0

    def _publish_maps(self, odom: OdometrySample, out: EkfOutput) -> None:
        stamp_ns = odom.stamp_ns
        for edge_map in out.edge_maps:
            self._edge_maps.publish(conversions.edge_map_to_msg(edge_map, stamp_ns))
        for link in out.links:
            self._links.publish(conversions.link_to_msg(link, stamp_ns))
        self._outputs += len(out.edge_maps) + len(out.links)
        state = "waiting" if out.base_in_edge is None else "arrived" if out.arrived else "mapping"
        self._answer(stamp_ns, state, ekf_messages.place_to_status(odom.base_in_odom, out))

    def _answer(self, stamp_ns: int, state: str, status: NodeStatus) -> None:
        status.header, status.node, status.outputs = conversions.header(stamp_ns, ""), self.get_name(), self._outputs
        status.next_event = self._next_event
        refused, server = self._door.report(), self._server
        status.state, status.detail = (
            state,
            "; ".join([refused] * bool(refused) + standing(server.noise, server.innovations)),
        )
        self._status.publish(status)

    def _publish_pose(self, odom: OdometrySample, out: EkfOutput) -> None:
        if out.base_in_edge is None or out.covariance is None:
            return
        at, where = odom.stamp_ns, out.base_in_edge
        if at < self._next_pose_ns and not (out.edge_maps or out.links):
            return
        self._next_pose_ns = at + round(self._config.pose_every_s * NS_PER_S)
        self._pose.publish(ekf_messages.pose_to_msg(at, out.traversal, where, out.covariance))
        self._tf.publish(ekf_messages.odom_in_edge_to_msg(at, out.traversal, where, odom.base_in_odom))

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._forget()
        response.success, response.message = True, "traversal and rotation bias forgotten"
        return response

    def _on_map_so_far(self, request: MapSoFar.Request, response: MapSoFar.Response) -> MapSoFar.Response:
        return map_so_far(self._server, self._stamp_ns, request, response)


def main() -> None:
    """Run the node until a signal."""
    run(EkfNode)
