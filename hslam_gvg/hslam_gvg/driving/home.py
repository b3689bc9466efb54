"""Homing on a node: drive there, stand, look once more, and only then announce it; or go back where there was none."""

import dataclasses
import math

import numpy as np

from hslam_gvg.driving.doing import GIVE_UP_AFTER, Following, Homing, Idle, Returning, Stand
from hslam_gvg.driving.follow import homing_on
from hslam_gvg.driving.listening import listening
from hslam_gvg.driving.now import Now, Step
from hslam_gvg.driving.pursuit import approach, pursue
from hslam_gvg.local_graph.node_view import node_view
from hslam_gvg.local_graph.polyline import apart_m, straight_on
from hslam_types.se2 import Array
from hslam_types.sensing import Velocity
from hslam_voronoi.branch_graph import Hub

APPROACH_S = 12.0
"""A node is noticed at most some 3 m away; who is still on the way after so long is held up."""
HINDERED = 3
"""Stopped so often, or for so long on the way, the robot looks at the node from where it is."""
STOOD, LISTENING_STEPS = 3, 160
"""Steps that a scan of the place needs to come in."""
SAME_M, SAME_CLEARANCES = 0.3, 0.6
"""A node of the new look this near to the one homed on is that one."""
MOVED_M = 0.2
"""A meet point that the new look has moved farther than this is driven to once more."""
DOUBTED_M = 2.0
"""A node looked for in vain is not noticed again for so much travel."""
STRAIGHT_ON_M = 1.2
"""So far straight on is followed until the next look finds a way."""
HOME_M = 0.2
"""The node departed from is come back to within this distance."""


def home(doing: Homing, now: Now) -> Step:
    """Drive to the node; stand there, look, and judge what is there."""
    away_m = math.hypot(doing.x - now.around.pose.x, doing.y - now.around.pose.y)
    near_m = now.config.home_tolerance_m
    if doing.is_end:
        near_m = max(0.12, min(now.config.end_tolerance_m, doing.clearance_m))
    hopeful = doing.stood == 0 and now.since_s(doing.since_ns) < APPROACH_S and doing.blocks < HINDERED
    if hopeful and away_m > near_m and now.around.line_is_clear(doing.x, doing.y):
        return Step(approach(doing.x, doing.y, now.around, now.config), doing)
    if doing.stood == 0:
        doing = dataclasses.replace(doing, turned=now.around.turned)
    turn = listening(doing.turned, now)
    if doing.stood + 1 < STOOD or (turn is not None and doing.stood < LISTENING_STEPS):
        return Step(turn or Velocity(), dataclasses.replace(doing, stood=doing.stood + 1))
    now.around.look()
    return _judged(doing, now)


def go_back(doing: Returning, now: Now) -> Step:
    """Follow the trail back to the node departed from; lost where there is none, or it cannot be reached."""
    leg, pose = now.traversal.leg, now.around.pose
    if leg is None or leg.node is None or now.since_s(doing.since_ns) > now.config.return_s:
        now.traversal.lose()
        return Step(Velocity(), Idle())
    node = leg.node
    if math.hypot(node.x_in_odom - pose.x, node.y_in_odom - pose.y) < HOME_M or doing.blocks >= GIVE_UP_AFTER:
        back = np.array([[node.x_in_odom, node.y_in_odom, node.clearance_m]])
        at = Homing(node.x_in_odom, node.y_in_odom, node.clearance_m, False, now.stamp_ns, back, returned=True)
        return Step(Velocity(), at)
    if now.around.look_is_due():
        now.around.look()
    path = np.vstack((doing.path, [[node.x_in_odom, node.y_in_odom, node.clearance_m]]))
    return Step(pursue(path, now.around, now.config), doing)


def _judged(doing: Homing, now: Now) -> Step:
    """Announce the node if the new look shows it too; else go on, or be back where the robot set out."""
    number = _same(doing, now)
    graph, leg, pose = now.around.graph, now.traversal.leg, now.around.pose
    if graph is None or number is None:
        if doing.returned and leg is not None and leg.node is not None:
            away_m = math.hypot(leg.node.x_in_odom - pose.x, leg.node.y_in_odom - pose.y)
            if away_m > max(SAME_M, SAME_CLEARANCES * leg.node.clearance_m):
                now.traversal.lose()
                return Step(Velocity(), Idle())
            now.traversal.arrive(leg.node, leg.branch)
            return Step(Velocity(), Idle(Stand(leg.node, leg.paths)))
        radius_m = max(0.3, 0.5 * doing.clearance_m)
        now.handled.add(doing.x, doing.y, radius_m, now.around.travel_m + DOUBTED_M)
        return Step(Velocity(), Following(_onward(doing.onward, now)))
    hub = graph.hub(number)
    moved = math.hypot(hub.x - pose.x, hub.y - pose.y) > MOVED_M
    if len(hub.ends) >= 3 and moved and not doing.again and not doing.returned:
        return Step(Velocity(), homing_on(hub, doing.onward, now, again=True))
    return _arrived(hub, [way.path for way in graph.ways(number)], now)


def _same(doing: Homing, now: Now) -> int | None:
    """Return the node of the new look nearest to the one homed on, if it is near enough to be that one."""
    graph = now.around.graph
    if graph is None:
        return None
    near: list[tuple[float, int]] = []
    for number in graph.nodes():
        hub = graph.hub(number)
        away_m = math.hypot(hub.x - doing.x, hub.y - doing.y)
        unheard = len(hub.ends) == 1 and graph.is_doubtful(number) and not doing.returned
        if not unheard and away_m < max(SAME_M, SAME_CLEARANCES * max(doing.clearance_m, hub.clearance)):
            near.append((away_m, number))
    return min(near)[1] if near else None


def _onward(path: Array, now: Now) -> Array:
    """Return what to follow where there was no node: the path so far, or straight on where it has ended."""
    x, y, _ = now.around.pose
    away = np.hypot(path[:, 0] - x, path[:, 1] - y)
    if len(path) - int(np.argmin(away)) > 5:
        return path
    trail = now.traversal.back(0.7)
    heading = now.around.pose.theta
    if len(trail) > 3:
        heading = math.atan2(trail[0, 1] - trail[-1, 1], trail[0, 0] - trail[-1, 0])
    return straight_on(x, y, heading, STRAIGHT_ON_M, 0.3)


def _arrived(hub: Hub, paths: list[Array], now: Now) -> Step:
    """Announce a node of the local graph, its branches counter-clockwise, and the one come along."""
    view, ordered = node_view(hub, paths, now.config.chord_m)
    back = now.traversal.back()
    apart = [apart_m(back, path, 2.0 + hub.clearance) for path in ordered] if len(back) > 1 else []
    known = any(math.isfinite(distance) for distance in apart)
    now.traversal.arrive(view, int(np.argmin(apart)) if known else -1)
    return Step(Velocity(), Idle(Stand(view, ordered)))
