"""At a node: home on it, probe it by the spokes, settle on it and announce it, or go on if it is none."""

import math

from hslam_gvg.motion import go_to
from hslam_gvg.probe import Probe
from hslam_gvg.reduced_graph import ReducedNode
from hslam_gvg.situation import Situation
from hslam_gvg.states import GvgState
from hslam_types.gvg_events import NodeKind, NodeView
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

PACE = 0.8
"""Share of the cruising speed: a node is come to slowly enough for the ring to go round."""
SAME_NODE_M = 0.8
"""A node of the new look this near to the one homed on is that one."""
SECOND_LOOKS = 2
SECOND_LOOK_M = 1.0
"""After so much travel a doubtful node is looked for again, so many times."""


class Homing:
    """The states HOMING, PROBING and SETTLING."""

    def __init__(self, situation: Situation) -> None:
        """Work on the situation shared by all states."""
        self._now = situation
        self._plan = Probe(())

    def home(self) -> Velocity:
        """Drive to the node as the map has it, and once there ask the map again."""
        command = self._approach()
        return command if command is not None else self._confirm(GvgState.PROBING)

    def probe(self) -> Velocity:
        """Step along each edge and back, so that the map shows what the node's middle hides."""
        now = self._now
        command = self._plan.step(now.pose, now.stamp_ns, now.pace(PACE), now.config.turn_rad_s, now.blocked)
        return command if command is not None else self._confirm(GvgState.SETTLING)

    def settle(self) -> Velocity:
        """After probing: drive to the node's refined place and announce it."""
        command = self._approach()
        return command if command is not None else self.arrive(self._now.aim())

    def give_up(self, state: GvgState) -> None:
        """The body was held in one of these states: go on without what it was trying."""
        if state is GvgState.HOMING:
            self._confirm(GvgState.PROBING)
        elif state is GvgState.SETTLING:
            self.arrive(self._now.aim())
        else:
            self._plan.skip()
            self._now.enter(GvgState.PROBING)

    def arrive(self, node: ReducedNode) -> Velocity:
        """Announce a node and stand still at it."""
        now = self._now
        kind = NodeKind.BOUNDARY_POINT if node.degree == 1 else NodeKind.MEET_POINT
        now.node = NodeView(kind, node.x, node.y, node.clearance_m, node.bearings)
        back = now.journey.came_from(node.x, node.y, now.config.chord_m)
        branch = -1 if back is None else now.node.nearest_branch(back)
        now.announcements.arrive(now.node, branch, now.journey.length_m)
        now.target = None
        now.enter(GvgState.IDLE)
        return Velocity()

    def _approach(self) -> Velocity | None:
        """Return the command towards the node, None once it is reached or cannot be."""
        now, target = self._now, self._now.aim()
        if now.distance_m(target.x, target.y) <= now.config.home_tolerance_m or now.stuck():
            return None
        return go_to(now.pose, target.x, target.y, now.pace(PACE), now.config.turn_rad_s)

    def _confirm(self, then: GvgState) -> Velocity:
        """Look again at the node: is it still one, and where exactly?"""
        now, aim = self._now, self._now.aim()
        points = now.map.points()
        graph = now.detector.graph(points, aim.x, aim.y)
        node = graph.node_near(aim.x, aim.y, SAME_NODE_M)
        if node is None:
            self._weak(aim, graph.passing(aim.x, aim.y))
            return Velocity()
        now.target = now.detector.homed(points, node)
        if then is GvgState.PROBING:
            self._plan = Probe.along(now.target, now.pose, now.config.probe_m)
        now.enter(then)
        return Velocity()

    def _weak(self, aim: ReducedNode, ways: tuple[float, ...]) -> None:
        """No strong node after all: go on along the edge that does not lead back."""
        now, config = self._now, self._now.config
        # From a little farther on the map may tell better; but not for ever.
        near = (math.hypot(aim.x - x, aim.y - y) < config.suppress_m for x, y in now.doubts)
        hidden_m = SECOND_LOOK_M if sum(near) < SECOND_LOOKS else config.suppress_travel_m
        now.handled.append((aim.x, aim.y, now.map.travel_m + hidden_m))
        now.doubts.append((aim.x, aim.y))
        back = now.journey.came_from(aim.x, aim.y, config.chord_m)
        if ways and back is not None:
            now.heading = max(ways, key=lambda way: abs(wrap(way - back)))
        now.target = None
        now.looked_m = now.map.travel_m
        now.enter(GvgState.RESUMING)
