"""What the other levels' statuses tell of the robot, for missions that use the atlas instead of making it."""

from collections.abc import Callable

from hslam_msgs.srv import MapSoFar
from rclpy.node import Node
from rclpy.task import Future

from hslam_atlas.missions.mission import Sense
from hslam_ros import conversions
from hslam_types.answer import Answer
from hslam_types.edge_map import EdgeMap
from hslam_types.errors import MessageError
from hslam_types.gvg_events import EventKind, GvgEvent
from hslam_types.se2 import SE2

_PATIENCE = 2
"""Looks after which an answer that has not come is not waited for."""
_KEPT = 100
"""Cycles whose statuses are kept until they are asked for."""


class RobotSense:
    """Keeps the statuses of the newest cycles, and asks the EKF level for the map so far where one is needed."""

    def __init__(self, node: Node, ekf: str) -> None:
        """Create the client of the service of the node ``ekf``."""
        self._client = node.create_client(MapSoFar, f"{ekf}/map_so_far")
        self._gvg: dict[int, Answer] = {}
        self._ekf = Answer(-1, 0, finished=False)
        self._by_cycle: dict[int, Answer] = {}
        self._map: EdgeMap | None = None
        self._at_arrival: EdgeMap | None = None
        self._asked: Future | None = None
        self._then: Callable[[], None] | None = None
        self._looks = 0

    def hear_gvg(self, answer: Answer) -> None:
        """Take the GVG level's answer to a cycle."""
        self._gvg[answer.stamp_ns] = answer
        while len(self._gvg) > _KEPT:
            del self._gvg[next(iter(self._gvg))]

    def hear_ekf(self, answer: Answer) -> None:
        """Take the EKF level's answer to a cycle."""
        self._ekf = self._by_cycle[answer.stamp_ns] = answer
        while len(self._by_cycle) > _KEPT:
            del self._by_cycle[next(iter(self._by_cycle))]

    def at(self, stamp_ns: int) -> Sense:
        """Return what is known of the robot at the end of a cycle."""
        gvg, ekf = self._gvg.get(stamp_ns), self._by_cycle.get(stamp_ns, self._ekf)
        if gvg is None:
            return Sense()
        base_in_frame: SE2 | None = None
        if ekf.base_in_edge is not None:  # running free, that may be a cycle older
            base_in_frame = ekf.base_in_edge @ ekf.base_in_odom.inverse() @ gvg.base_in_odom
        return Sense(
            gvg.base_in_odom, ekf.traversal, base_in_frame, self._so_far, gvg.clearance_m, idle=gvg.state == "idle"
        )

    def wait_for_map(self, arrival: GvgEvent, then: Callable[[], None]) -> None:
        """Ask for what was seen on the way to an arrival that has no edge-map, then go on, with or without it."""
        self._at_arrival = None
        if not self._client.service_is_ready():
            then()
            return
        request = MapSoFar.Request(at_arrival=True, arrival=conversions.event_to_msg(arrival))
        future = self._client.call_async(request)
        self._then, self._looks = then, 0
        future.add_done_callback(lambda done: self._on_map_at_arrival(then, done))

    def look(self) -> None:
        """Give up waiting for an answer that may have been lost; called now and then."""
        self._looks += 1
        if self._then is not None and self._looks > _PATIENCE:
            self._go_on(self._then)

    def _on_map_at_arrival(self, then: Callable[[], None], done: Future) -> None:
        if self._then is then:
            self._at_arrival = _map_in(done)
            self._go_on(then)

    def _go_on(self, then: Callable[[], None]) -> None:
        self._then = None
        then()

    def _so_far(self, arrival: GvgEvent | None) -> EdgeMap | None:
        """Return the map at an arrival; without one, what came of the last time, and ask for a newer one."""
        if arrival is not None:
            found = self._at_arrival
            return found if found is not None and found.arrival == arrival.sequence else None
        if self._asked is None and self._client.service_is_ready():
            self._asked = self._client.call_async(MapSoFar.Request())
            self._asked.add_done_callback(self._on_map)
        newest, self._map = self._map, None
        return newest

    def _on_map(self, done: Future) -> None:
        self._map, self._asked = _map_in(done), None


def unmapped(events: tuple[GvgEvent, ...], edge_maps: tuple[EdgeMap, ...]) -> GvgEvent | None:
    """Return the arrival of a cycle that comes without its edge-map, None if there is none."""
    mapped = {edge_map.arrival for edge_map in edge_maps}
    arrivals = (event for event in events if event.kind is EventKind.ARRIVAL)
    return next((event for event in arrivals if event.sequence not in mapped), None)


def _map_in(done: Future) -> EdgeMap | None:
    response = done.result()
    if response is None or not response.success:
        return None
    try:
        return conversions.edge_map_from_msg(response.edge_map)
    except MessageError:
        return None
