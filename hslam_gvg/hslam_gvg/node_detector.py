"""Where on the recent path a node of the reduced GVG lies, and where exactly.

The third obstacle of a meet point often answers only when the robot is past it, so nodes are looked for
behind, in the local map, not at the robot.
"""

import math
from collections.abc import Sequence

from hslam_gvg.closest_points import closest_points
from hslam_gvg.config import GvgConfig
from hslam_gvg.control import home
from hslam_gvg.reduced_graph import ReducedGraph, ReducedNode
from hslam_gvg.voronoi_graph import voronoi_graph
from hslam_types.se2 import SE2, Array

EQUIDISTANT_M = 0.3
"""Obstacles whose distances differ by no more than this meet here."""
GAP_BY_ROOM = 1.2
"""A way through is at least this multiple of the room about the robot wide."""
HOMING_STEPS = 12
"""The homing law converges in a few; this bounds it."""
AHEAD_M = 0.25
"""A node this little ahead counts as reached."""


class NodeDetector:
    """Judges the local map."""

    def __init__(self, config: GvgConfig) -> None:
        """Keep the configuration."""
        self._config = config

    def graph(self, points: Array, x: float, y: float) -> ReducedGraph:
        """Return the reduced graph round a place."""
        config = self._config
        near = closest_points(points, x, y, config.reach_m, config.separation, most=1)
        room = near[0].distance_m if near else config.reach_m
        # Near walls are known densely, far ones have holes: a hole must be wider to count as a way where there is room.
        gap_m = min(config.passable_gap_m, max(config.narrowest_gap_m, GAP_BY_ROOM * room))
        raw = voronoi_graph(points, x, y, config.horizon_m, gap_m)
        return ReducedGraph(raw, config.dead_end_m, config.chord_m)

    def passed(
        self,
        graph: ReducedGraph,
        base_in_odom: SE2,
        path: Sequence[tuple[float, float]],
        handled: Sequence[tuple[float, float]],
    ) -> ReducedNode | None:
        """Return a node that the robot has reached or passed on its recent ``path`` and that is not handled."""
        config = self._config
        x, y, heading = base_in_odom
        found: list[tuple[float, ReducedNode]] = []
        for node in graph.nodes:
            dx, dy = node.x - x, node.y - y
            distance = math.hypot(dx, dy)
            if distance > config.look_back_m or dx * math.cos(heading) + dy * math.sin(heading) > AHEAD_M:
                continue
            off = min((math.hypot(px - node.x, py - node.y) for px, py in path), default=distance)
            if min(off, distance) > max(0.6, 0.6 * node.clearance_m):
                continue
            hidden = max(config.suppress_m, node.clearance_m)
            if all(math.hypot(node.x - hx, node.y - hy) > hidden for hx, hy in handled):
                found.append((distance, node))
        return min(found, key=lambda entry: entry[0])[1] if found else None

    def homed(self, points: Array, node: ReducedNode) -> ReducedNode:
        """Return the node moved to where its obstacles are equally far, by the homing law run in the map."""
        config = self._config
        x, y = node.x, node.y
        clearance = node.clearance_m
        for _ in range(HOMING_STEPS):
            near = closest_points(points, x, y, config.reach_m, config.separation)
            meeting = [c for c in near if c.distance_m < near[0].distance_m + EQUIDISTANT_M]
            if len(meeting) < 2:
                return node
            vx, vy = home(meeting, 1.0)
            size = math.hypot(vx, vy)
            share = min(1.0, 0.15 / max(size, 1e-9)) * 0.7
            x, y = x + share * vx, y + share * vy
            clearance = sum(c.distance_m for c in meeting) / len(meeting)
            if size < 0.01:
                break
        if math.hypot(x - node.x, y - node.y) > EQUIDISTANT_M:
            return node
        return ReducedNode(x, y, clearance, node.bearings)
