"""What others see of the atlas: the graph and its frames as they change, markers while somebody looks."""

from hslam_msgs.msg import Atlas
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from hslam_atlas.atlas_in_use import AtlasInUse
from hslam_atlas.atlas_messages import atlas_to_markers, atlas_to_msg, edge_in_map_to_msg, edge_nowhere_to_msg
from hslam_atlas.picture import node_poses
from hslam_ros.qos import LATCHED
from hslam_types.se2 import SE2

_LOOK_S = 1.0
"""How often markers are drawn at most: they take a look at every edge-map."""


class AtlasPicture:
    """Publishes; everything is latched, so that whoever comes late sees the newest too."""

    def __init__(self, node: Node, atlas: AtlasInUse) -> None:
        """Create the topics on ``node``; an atlas that was taken up is shown at once."""
        self._in_use = atlas
        self._atlas = node.create_publisher(Atlas, "~/atlas", LATCHED)
        self._markers = node.create_publisher(MarkerArray, "~/markers", LATCHED)
        self._tf = node.create_publisher(TFMessage, "/tf_static", LATCHED)  # holds from one event to the next
        self._poses: dict[int, SE2] = {}  # the nodes' in map, composed when the atlas changes
        self._stamp_ns = 0
        self._drawn = self._shown = False
        self._lookers = 0
        node.create_timer(_LOOK_S, self._draw, clock=Clock(clock_type=ClockType.STEADY_TIME))
        if atlas.server.state.graph.nodes:
            self.show_graph(0)

    def show_graph(self, stamp_ns: int) -> None:
        """Publish the graph as it is now."""
        self._poses, self._stamp_ns, self._drawn = node_poses(self._in_use.server.state.graph), stamp_ns, False
        self._atlas.publish(atlas_to_msg(self._in_use.server, self._poses, stamp_ns))

    def show_other_graph(self) -> None:
        """Publish the graph of another atlas that has taken the place of the last."""
        self.show_graph(self._stamp_ns)

    def show_frame(self, traversal: int, stamp_ns: int) -> None:
        """Publish where the frame lies that the robot is tracked in; where that is not known, that it lies nowhere.

        ``traversal``: whose frame that is, -1 without one.
        """
        transform = edge_in_map_to_msg(self._in_use.server, self._poses, stamp_ns)
        if transform is not None:
            self._tf.publish(transform)
            self._shown = True
        elif self._shown and traversal >= 0:  # it was, and latched: whoever looks must not go on believing it
            self._tf.publish(edge_nowhere_to_msg(traversal, stamp_ns))
            self._shown = False

    def _draw(self) -> None:
        lookers, before = self._markers.get_subscription_count(), self._lookers
        self._lookers = lookers
        # RViz asks for no old messages: who comes is shown the picture anew.
        if lookers > before or (lookers and not self._drawn):
            self._markers.publish(atlas_to_markers(self._in_use.server, self._poses, self._stamp_ns))
            self._drawn = True
