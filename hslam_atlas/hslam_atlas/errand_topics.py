"""What people click at in RViz: where to go, and about where the robot is."""

from collections.abc import Callable

from geometry_msgs.msg import PointStamped, PoseStamped, PoseWithCovarianceStamped
from rclpy.node import Node

from hslam_atlas.atlas_messages import MAP
from hslam_atlas.errors import AtlasError
from hslam_atlas.missions.destination import from_map
from hslam_atlas.server import AtlasServer
from hslam_ros.checks import number
from hslam_ros.conversions import pose_in_plane
from hslam_ros.door import Door
from hslam_types.errors import MessageError
from hslam_types.se2 import SE2


class ErrandTopics:
    """Takes points and poses in `map`; what cannot be done is told in the log, and changes nothing."""

    def __init__(
        self, node: Node, door: Door, server: Callable[[], AtlasServer], supersede: Callable[[], None]
    ) -> None:
        """Hear the topics on ``node``; ``supersede`` is called when a click takes the place of a client's goal."""
        self._node, self._server, self._supersede = node, server, supersede
        door.hear(PoseStamped, "goal_pose", _pose, self._go, 10)
        door.hear(PointStamped, "clicked_point", _point, self._go, 10)
        door.hear(PoseWithCovarianceStamped, "initialpose", lambda msg: _pose(_of(msg)), self._hint, 10)

    def _go(self, place: SE2) -> None:
        server = self._server()
        try:
            server.dispatch.navigate(from_map(server.state.graph, server.state.maps, place.x, place.y))
        except AtlasError as error:
            self._node.get_logger().warning(f"clicked at ({place.x:.1f}, {place.y:.1f}): {error}")
        else:
            self._supersede()

    def _hint(self, base_in_map: SE2) -> None:
        try:
            self._server().dispatch.hint(base_in_map)
        except AtlasError as error:
            self._node.get_logger().warning(f"initialpose: {error}")


def _of(msg: PoseWithCovarianceStamped) -> PoseStamped:
    return PoseStamped(header=msg.header, pose=msg.pose.pose)


def _pose(msg: PoseStamped) -> SE2:
    _check_frame(msg.header.frame_id)
    return pose_in_plane(msg.pose, "pose")


def _point(msg: PointStamped) -> SE2:
    _check_frame(msg.header.frame_id)
    return SE2(number(msg.point.x, "point.x"), number(msg.point.y, "point.y"), 0.0)


def _check_frame(frame: str) -> None:
    if frame != MAP:
        raise MessageError(f"header.frame_id = '{frame}' is not '{MAP}'")
