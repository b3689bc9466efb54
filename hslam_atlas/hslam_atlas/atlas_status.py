"""What the node says of itself: its answer to a cycle, whether it knows where the robot is and has all its maps."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hslam_msgs.msg import NodeStatus

from hslam_atlas.explore import driven_once
from hslam_atlas.inbox import Inbox
from hslam_atlas.missions.navigate import Navigate, Progress
from hslam_atlas.server import AtlasOutput, AtlasServer
from hslam_ros.conversions import header

_ENDED = {"localising": "localised", "exploring": "explored"}


def status_of(server: AtlasServer, out: AtlasOutput, stamp_ns: int) -> NodeStatus:
    """Return the answer to a cycle: graph and mission; the run has ended where the configuration's mission has."""
    graph, left, dispatch = server.state.graph, server.unexplored, server.dispatch
    status = NodeStatus(header=header(stamp_ns, ""))
    status.detail = f"{len(graph.nodes)} nodes, {len(graph.edges)} edges, {left} unexplored"
    status.state = dispatch.doing
    if out.finished:
        status.state = _ENDED.get(status.state, status.state)
        if status.state == "explored" and left:
            status.state = "stopped"
            status.detail += " and out of reach"
        elif status.state == "explored" and (once := driven_once(graph)):
            status.detail += f", {once} edges driven once only"
        elif status.state == "localised" and dispatch.about() is None:
            status.state = "lost"
    if isinstance(dispatch.now, Navigate) and dispatch.now.progress is Progress.UNREACHABLE:
        status.detail += f"; {dispatch.now.why}"
    if server.unsaved is not None:
        status.detail += f", not saved: {server.unsaved}"
    status.finished = out.finished and dispatch.of_itself and server.state.config.mission == "explore"
    return status


def diagnostics_to_msg(server: AtlasServer, inbox: Inbox, stamp_ns: int) -> DiagnosticArray:
    """Return what there is to be told now and then, as diagnostics of the time (ns) of the last cycle."""
    return DiagnosticArray(header=header(stamp_ns, ""), status=[_whereabouts(server), _edge_maps(inbox, stamp_ns)])


def _whereabouts(server: AtlasServer) -> DiagnosticStatus:
    """Return whether the robot's place is known."""
    node, locator = server.dispatch.about(), server.dispatch.locator
    places = 0 if locator is None else len(locator.places)
    return DiagnosticStatus(
        level=DiagnosticStatus.OK if node is not None else DiagnosticStatus.WARN,
        name="atlas: whereabouts",
        message=f"at or from node {node}" if node is not None else "where the robot is, is in doubt",
        values=[
            KeyValue(key="doing", value=server.dispatch.doing),
            KeyValue(key="places_possible", value=str(places)),
        ],
    )


def _edge_maps(inbox: Inbox, stamp_ns: int) -> DiagnosticStatus:
    """Return whether an event waits for what the EKF level makes of it, and how often that was late."""
    awaited = inbox.awaited(stamp_ns)
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN if awaited else DiagnosticStatus.OK,
        name="atlas: edge-maps",
        message=awaited or "none is awaited",
        values=[
            KeyValue(key="late", value=str(inbox.late)),
            KeyValue(key="latest_s", value=f"{inbox.latest_s:.2f}"),
        ],
    )
