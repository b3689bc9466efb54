"""Setting out: turning to a branch and departing by it, reaching the GVG from anywhere, a straight drive off it."""

import math

import numpy as np

from hslam_gvg.driving.doing import Accessing, Crossing, Following, GoingStraight, Idle, Turning
from hslam_gvg.driving.listening import listening
from hslam_gvg.driving.now import Now, Step
from hslam_gvg.driving.pursuit import approach, pursue
from hslam_gvg.driving.traversal import Leg
from hslam_gvg.local_graph.local_graph import LocalGraph, Way
from hslam_gvg.local_graph.polyline import straight_on, turned_from
from hslam_gvg.motion import turn_to
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

LISTENED_S = 0.6
"""A robot that has just been put down looks for so long before it judges."""
SEARCHING_RAD_S = 0.5
"""A look round by a robot that sees no way takes some 12 s at this rate."""
TURN_S = 15.0
"""A turn on the spot that takes longer is over: the base turns no farther."""
SHORT = 3
"""Points of a way that leads hardly anywhere."""
DIRECTION_M = 0.8
"""The direction of a way is that of its first metres: of less, the grid's cells decide."""
LEFT_ALONE_M, LEFT_ALONE_CLEARANCES = 0.8, 1.5
"""The node left is not noticed again for so much travel; the first adds to how far the robot looks back."""
STRAIGHT_BLOCKS = 2
"""Held up so often, a straight drive is over."""
AHEAD_M = 1.2
"""So far ahead lies what is driven to in the open."""


def turn(doing: Turning, now: Now) -> Step:
    """Turn to the branch; depart once it lies ahead."""
    node, pose = doing.at.view, now.around.pose
    bearing = node.bearings_in_odom[doing.branch]
    if abs(wrap(bearing - pose.theta)) > now.config.aligned and now.since_s(doing.since_ns) < TURN_S:
        return Step(turn_to(pose, bearing, now.config.turn_rad_s), doing)
    now.traversal.depart(Leg(node, doing.branch, doing.at.paths))
    now.handled.clear()
    until_m = now.around.travel_m + max(now.config.look_back_m + LEFT_ALONE_M, LEFT_ALONE_CLEARANCES * node.clearance_m)
    now.handled.add(node.x_in_odom, node.y_in_odom, max(0.3, node.clearance_m), until_m)
    return Step(Velocity(), Following(doing.at.paths[doing.branch]))


def access(doing: Accessing, now: Now) -> Step:
    """Look round until there is a graph with a clear line to it; then follow it, as asked or as the robot faces."""
    waited_s = now.since_s(doing.since_ns)
    if waited_s <= LISTENED_S:
        return Step(Velocity(), doing)
    to_side = listening(doing.turned, now)
    if to_side is not None and waited_s < now.config.access_s:
        return Step(to_side, doing)
    around = now.around
    around.look()
    heading = around.pose.theta if doing.way is None else doing.way
    way = _way_in_reach(around.graph, heading, now) if around.graph is not None else None
    if way is not None:
        now.traversal.access()
        now.handled.clear()
        here = np.array([[around.pose.x, around.pose.y, around.clearance(around.pose.x, around.pose.y)]])
        return Step(Velocity(), Following(np.vstack((here, way.path))))
    if around.is_in_the_open() and not doing.crossed:
        return Step(Velocity(), Crossing(heading, around.travel_m + now.config.across_m))
    if waited_s < now.config.access_s:
        return Step(Velocity(0.0, SEARCHING_RAD_S), doing)
    now.traversal.lose()
    return Step(Velocity(), Idle())


def cross(doing: Crossing, now: Now) -> Step:
    """Drive straight on until the open is left or a graph is in reach; whichever it is, access goes on from there."""
    around = now.around
    if around.look_is_due():
        around.look()
    given_up = around.travel_m >= doing.until_m
    in_reach = around.graph is not None and _way_in_reach(around.graph, doing.heading, now) is not None
    if given_up or in_reach or not around.is_in_the_open():
        return Step(Velocity(), Accessing(now.stamp_ns, around.turned, doing.heading, crossed=given_up))
    ahead = straight_on(around.pose.x, around.pose.y, doing.heading, AHEAD_M, AHEAD_M)
    return Step(pursue(ahead, around, now.config), doing)


def go_straight(doing: GoingStraight, now: Now) -> Step:
    """Drive to the point; idle when there, lost when something stands in the way."""
    around = now.around
    if around.look_is_due():
        around.look()
    if math.hypot(doing.x - around.pose.x, doing.y - around.pose.y) <= now.config.home_tolerance_m:
        return Step(Velocity(), Idle())
    if doing.blocks >= STRAIGHT_BLOCKS:
        now.traversal.lose()
        return Step(Velocity(), Idle())
    return Step(approach(doing.x, doing.y, around, now.config), doing)


def _way_in_reach(graph: LocalGraph, heading: float, now: Now) -> Way | None:
    """Return a way, the nearest to a heading, from the nearest place of the graph that the body gets to straight.

    There is such a place: away from the nearest obstacle the line to equidistance is clear (paper, access).
    """
    around = now.around
    x, y, _ = around.pose
    paths = graph.paths()
    places = np.vstack([path for _, path in paths])
    owners = [(branch, index) for branch, path in paths for index in range(len(path))]
    for at in np.argsort(np.hypot(places[:, 0] - x, places[:, 1] - y), kind="stable"):
        if around.line_is_clear(float(places[at, 0]), float(places[at, 1])):
            branch, index = owners[at]
            ways = [
                way
                for forwards in (True, False)
                for way in graph.onwards(branch, index, forwards, 0.0, lambda _: False)
            ]
            return min(ways, key=lambda way: (len(way.path) <= SHORT, turned_from(way.path, heading, DIRECTION_M)))
    return None
