"""Following an edge: along the path of the local graph that goes on with the one set out on, to the next node."""

import dataclasses
import math

import numpy as np

from hslam_gvg.driving.continuity import continued, unlike_m, ways_at
from hslam_gvg.driving.doing import GIVE_UP_AFTER, Attending, Following, Homing, Idle, Returning, Stand
from hslam_gvg.driving.listening import listening
from hslam_gvg.driving.now import Now, Step
from hslam_gvg.driving.pursuit import pursue
from hslam_gvg.driving.traversal import TRAIL_STEP_M
from hslam_gvg.local_graph.polyline import arc_lengths, chord_bearing, length_m, nearest
from hslam_types.gvg_events import NodeKind, NodeView
from hslam_types.se2 import Array
from hslam_types.sensing import Velocity
from hslam_voronoi.branch_graph import Hub

AT_M = 0.12
"""A meet point this near, along the path or straight, is reached: what is left is homing."""
ENDED_M = 0.15
"""With less left of the path, it ends."""
END_LOOKS, END_TURN_RAD_S = 4, 0.5
"""So many looks, turning, find nothing beyond an end before it is one."""
AGAIN_M = 0.05
"""A look that found no way on is repeated after so much travel."""
NEAR_ENOUGH_AFTER, NEAR_ENOUGH_M = 3, 1.0
"""Stopped so often, a node this near is homed on from there."""
ANEW = 2
"""So many times another way is taken where the one followed has ended,"""
ANEW_AFTER_M = 6.0
"""and as often again after so long a way."""
TRODDEN_M, TRAIL_BACK_M = 0.28, 3.2
"""A way whose points are on average no farther from the last metres of the trail leads back."""
OFF_M, LEAST_WAY_M = 0.6, 0.5
BACK_ON_M = 1.5
"""A robot that has strayed goes back on the graph from as far as this, if nothing is between."""
LEAST_EDGE_M = 1.0
"""No end is announced on a shorter way: it would be the node just left, seen anew."""


def follow(doing: Following, now: Now) -> Step:
    """Look every so often, home on a node that is reached or was passed, else drive on."""
    if now.around.look_is_due() or (doing.missed and now.around.travelled_since_look_m > AGAIN_M):
        doing = _looked(doing, now)
        if (passed := _passed(doing, now)) is not None:
            now.traversal.rewind(passed.x, passed.y, now.config.look_back_m)
            return Step(Velocity(), homing_on(passed, doing.path, now))
    if (hub := _reached(doing, now)) is not None:
        return Step(Velocity(), homing_on(hub, doing.path, now))
    if _rest_m(doing, now) < ENDED_M:
        doing = _looked(doing, now)
        if _rest_m(doing, now) < ENDED_M:
            if doing.end_looks >= END_LOOKS:
                return _at_end(dataclasses.replace(doing, end_looks=0), now)
            return Step(Velocity(0.0, END_TURN_RAD_S), dataclasses.replace(doing, end_looks=doing.end_looks + 1))
        doing = dataclasses.replace(doing, end_looks=0)
    if doing.blocks >= GIVE_UP_AFTER:
        return _at_end(doing, now)
    return Step(pursue(doing.path, now.around, now.config), doing)


def homing_on(hub: Hub, onward: Array, now: Now, *, again: bool = False) -> Homing:
    """Return the homing on a node of the local graph."""
    return Homing(hub.x, hub.y, hub.clearance, len(hub.ends) == 1, now.stamp_ns, onward, again=again)


def _looked(doing: Following, now: Now) -> Following:
    """Look, and go on along the way of the new graph that continues the path."""
    around = now.around
    around.look()
    graph = around.graph
    if graph is None:
        return dataclasses.replace(doing, missed=True)
    way = continued(graph, doing.path, around.pose, now.handled, around.travel_m, now.config.unlike_m)
    if way is None:
        return dataclasses.replace(doing, missed=True)
    return dataclasses.replace(
        doing,
        path=way.path,
        hub=graph.hub(way.end),
        is_exit=graph.is_exit(way.end),
        is_doubtful=graph.is_doubtful(way.end),
        missed=False,
    )


def _reached(doing: Following, now: Now) -> Hub | None:
    """Return the node at the path's end if the robot is there."""
    hub = doing.hub
    if hub is None or doing.is_exit or doing.missed or len(hub.ends) == 2:
        return None
    straight_m = math.hypot(hub.x - now.around.pose.x, hub.y - now.around.pose.y)
    near_m = (
        AT_M if len(hub.ends) > 1 or doing.is_doubtful else max(AT_M, min(now.config.end_tolerance_m, hub.clearance))
    )
    near_enough = doing.blocks >= NEAR_ENOUGH_AFTER and straight_m < NEAR_ENOUGH_M
    return hub if min(_rest_m(doing, now), straight_m) < near_m or near_enough else None


def _passed(doing: Following, now: Now) -> Hub | None:
    """Return the nearest meet point on the way just driven, unless it is hidden."""
    around, graph = now.around, now.around.graph
    trail = now.traversal.back(now.config.look_back_m)
    if graph is None or len(trail) < 3:
        return None
    found: list[tuple[float, int]] = []
    for number in graph.nodes():
        hub = graph.hub(number)
        away_m = math.hypot(hub.x - around.pose.x, hub.y - around.pose.y)
        on_trail = away_m <= now.config.look_back_m and nearest(trail, hub.x, hub.y)[1] < 0.2
        if len(hub.ends) >= 3 and hub is not doing.hub and on_trail and not now.handled.hides(hub, around.travel_m):
            found.append((away_m, number))
    return graph.hub(min(found)[1]) if found else None


def _rest_m(doing: Following, now: Now) -> float:
    index, off_m = nearest(doing.path, now.around.pose.x, now.around.pose.y)
    return length_m(doing.path[index:]) + off_m


def attend(doing: Attending, now: Now) -> Step:
    """Turn until the place has been heard from all round, then go on along the path if it does not end there."""
    turn = listening(doing.turned, now)
    if turn is not None:
        return Step(turn, doing)
    return Step(Velocity(), _looked(doing.then, now))


def _at_end(doing: Following, now: Now) -> Step:
    """Take any way of the graph that does not lead back; else the edge ends here, or never was one."""
    if now.config.listening_turn > 0.0 and not doing.attended:
        then = dataclasses.replace(doing, attended=True, blocks=0)
        return Step(Velocity(), Attending(then, now.around.turned))
    if now.traversal.length_m > doing.anew_m + ANEW_AFTER_M:
        doing = dataclasses.replace(doing, anew=0)
    if doing.anew < ANEW:
        now.around.look()
        if (other := _another_way(doing, now)) is not None:
            return Step(Velocity(), other)
    node, pose = (now.traversal.leg.node if now.traversal.leg else None), now.around.pose
    far = node is None or math.hypot(pose.x - node.x_in_odom, pose.y - node.y_in_odom) > max(
        LEAST_EDGE_M, node.clearance_m + 0.5
    )
    # A branch of a meet point that no look shows any more never was one.
    imagined = doing.missed and node is not None and node.degree > 1
    if far and now.traversal.length_m > LEAST_EDGE_M and not imagined:
        return _arrived_at_end(now)
    return Step(Velocity(), Returning(now.traversal.back(), now.stamp_ns))


def _another_way(doing: Following, now: Now) -> Following | None:
    around, graph = now.around, now.around.graph
    if graph is None:
        return None
    trail = now.traversal.back(TRAIL_BACK_M)
    ways = [
        (unlike_m(way.path, doing.path, around.pose) + 0.3 * off_m, way)
        for off_m, way in ways_at(graph, around.pose, now.handled, around.travel_m, BACK_ON_M)
        if length_m(way.path) >= LEAST_WAY_M
        and (off_m <= OFF_M or around.line_is_clear(float(way.path[0, 0]), float(way.path[0, 1])))
        and not _trodden(way.path, trail)
    ]
    best = min(ways, key=lambda found: found[0], default=None)
    if best is None:
        return None
    way = best[1]
    here = np.array([[around.pose.x, around.pose.y, around.clearance(around.pose.x, around.pose.y)]])
    return Following(
        np.vstack((here, way.path)),
        graph.hub(way.end),
        graph.is_exit(way.end),
        anew=doing.anew + 1,
        anew_m=now.traversal.length_m,
        attended=doing.attended,
    )


def _trodden(path: Array, trail: Array) -> bool:
    """Whether a path leads back along the trail (both k x 3)."""
    if len(trail) < 3:
        return False
    along = arc_lengths(path)
    at = np.arange(0.4, min(1.3, float(along[-1])) + 1e-6, 0.15)
    x, y = np.interp(at, along, path[:, 0]), np.interp(at, along, path[:, 1])
    away = np.hypot(x[:, None] - trail[:, 0], y[:, None] - trail[:, 1]).min(axis=1)
    return float(away.mean()) < TRODDEN_M


def _arrived_at_end(now: Now) -> Step:
    """Announce a boundary point where the robot is: the one way from here is back."""
    x, y, heading = now.around.pose
    back = np.vstack(([[x, y, TRAIL_STEP_M]], now.traversal.back()))
    bearing = chord_bearing(back, now.config.chord_m) if len(back) > 1 else heading + math.pi
    clearance = now.around.clearance(x, y)
    view = NodeView(NodeKind.BOUNDARY_POINT, x, y, clearance if math.isfinite(clearance) else 1.0, (bearing,))
    now.traversal.arrive(view, 0)
    return Step(Velocity(), Idle(Stand(view, (back,))))
