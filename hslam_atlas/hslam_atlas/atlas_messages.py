"""The atlas as messages: the graph for other programs, markers for display."""

from geometry_msgs.msg import Point
from hslam_msgs.msg import Atlas, AtlasEdge, AtlasNode
from std_msgs.msg import ColorRGBA
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from hslam_atlas.picture import edge_frame_in_map
from hslam_atlas.server import AtlasServer
from hslam_ros.conversions import edge_frame, header, pose_to_msg
from hslam_ros.transforms import transform_to_msg
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

MAP = "map"
_NOWHERE = "nowhere"
_MEET = ColorRGBA(r=0.1, g=0.4, b=0.9, a=1.0)
_BOUNDARY = ColorRGBA(r=0.9, g=0.4, b=0.1, a=1.0)
_EDGE = ColorRGBA(r=0.3, g=0.3, b=0.3, a=1.0)
_LANDMARK = ColorRGBA(r=1.0, g=0.4, b=0.7, a=1.0)


def atlas_to_msg(server: AtlasServer, poses: dict[int, SE2], stamp_ns: int) -> Atlas:
    """Return the graph with every node that can be placed in ``map``; ``poses`` are theirs (`node_poses`)."""
    graph = server.state.graph
    slots = {node_id: node.slots() for node_id, node in graph.nodes.items()}
    msg = Atlas(header=header(stamp_ns, MAP), closures=server.state.closures, hypotheses=len(server.questions.open))
    for node_id, pose in poses.items():
        node = graph.nodes[node_id]
        msg.nodes.append(
            AtlasNode(
                id=node_id,
                kind=int(node.kind),
                clearance=float(node.clearance_m),
                position=Point(x=pose.x, y=pose.y),
                edges=[-1 if edge is None else edge for edge in (node.branches[key].edge for key in slots[node_id])],
            )
        )
    for edge_id, edge in sorted(graph.edges.items()):
        start, stop = edge.ends
        if start.node in poses:
            msg.edges.append(
                AtlasEdge(
                    id=edge_id,
                    from_node=start.node,
                    from_branch=slots[start.node].index(start.branch),
                    to_node=stop.node,
                    to_branch=slots[stop.node].index(stop.branch),
                    length=float(edge.path_length_m),
                    frame_in_map=pose_to_msg(edge_frame_in_map(edge, poses)),
                )
            )
    return msg


def edge_in_map_to_msg(server: AtlasServer, poses: dict[int, SE2], stamp_ns: int) -> TFMessage | None:
    """Return the transform map -> edge of the frame the robot is tracked in, None where that cannot be placed."""
    tracked = server.dispatch.tracked()
    if tracked is None or tracked[1] not in poses:
        return None
    traversal, node, frame_in_node = tracked
    return transform_to_msg(stamp_ns, MAP, edge_frame(traversal), poses[node] @ frame_in_node)


def edge_nowhere_to_msg(traversal: int, stamp_ns: int) -> TFMessage:
    """Return the transform that takes a frame out of `map`: while nobody knows where the robot is, none leads there."""
    return transform_to_msg(stamp_ns, _NOWHERE, edge_frame(traversal), SE2())


def atlas_to_markers(server: AtlasServer, poses: dict[int, SE2], stamp_ns: int) -> MarkerArray:
    """Return nodes as spheres, edges as lines and landmarks as points in ``map``."""
    graph = server.state.graph
    edges = _marker(stamp_ns, "edges", Marker.LINE_LIST, 0.1, _EDGE)
    landmarks = _marker(stamp_ns, "landmarks", Marker.POINTS, 0.15, _LANDMARK)
    kinds = {
        NodeKind.MEET_POINT: _marker(stamp_ns, "meet_points", Marker.SPHERE_LIST, 0.8, _MEET),
        NodeKind.BOUNDARY_POINT: _marker(stamp_ns, "boundary_points", Marker.SPHERE_LIST, 0.8, _BOUNDARY),
    }
    for node_id, pose in poses.items():
        kinds[graph.nodes[node_id].kind].points.append(Point(x=pose.x, y=pose.y))
    for edge_id, edge in sorted(graph.edges.items()):
        if edge.ends[0].node in poses:
            edges.points += [Point(x=poses[end.node].x, y=poses[end.node].y) for end in edge.ends]
            seen = edge_frame_in_map(edge, poses).apply_all(server.state.maps.get(edge_id).landmarks)
            landmarks.points += [Point(x=x, y=y) for x, y in seen.tolist()]
    return MarkerArray(markers=[edges, landmarks, *kinds.values()])


def _marker(stamp_ns: int, namespace: str, kind: int, size_m: float, colour: ColorRGBA) -> Marker:
    marker = Marker(header=header(stamp_ns, MAP), ns=namespace, type=kind, action=Marker.ADD, color=colour)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size_m
    return marker
