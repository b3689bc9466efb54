"""What all states share: where the robot is, what it knows, what it is doing and since when."""

import math

from hslam_gvg.announcements import Announcements
from hslam_gvg.config import GvgConfig
from hslam_gvg.journey import Journey
from hslam_gvg.node_detector import NodeDetector
from hslam_gvg.obstacle_map import ObstacleMap
from hslam_gvg.obstructions import Obstructions
from hslam_gvg.reduced_graph import ReducedGraph, ReducedNode
from hslam_gvg.states import ON_EDGE, GvgError, GvgState
from hslam_gvg.trail import Trail
from hslam_types.gvg_events import NodeView
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample

STUCK_S = 4.0
"""Held up for longer than four sweeps of the ring, what was tried is given up."""


class Situation:
    """The robot in its surroundings at one step; positions (m) and directions (rad) are in odom."""

    def __init__(self, config: GvgConfig, announcements: Announcements | None = None) -> None:
        """Start idle, knowing nothing; ``announcements`` goes on from an earlier situation's."""
        self.config = config
        self.announcements = announcements or Announcements()
        self.map = ObstacleMap(config)
        self.detector = NodeDetector(config)
        self.journey = Journey()
        """The path along the edge under way."""
        self.trail = Trail()
        self.obstructions = Obstructions(config)
        self.state = GvgState.IDLE
        self.pose, self.stamp_ns = SE2(), 0
        self.node: NodeView | None = None
        """The node the robot stands at, from its arrival to its departure."""
        self.target: ReducedNode | None = None
        """The node homed on."""
        self.heading = 0.0
        """Direction (rad) to turn to, to go on along the edge."""
        self.course: float | None = None
        """Direction (rad) in which the local graph leads on, since the last look."""
        self.room_m = config.wide_m
        """The usual clearance on the edge under way."""
        self.looked_m = 0.0
        """Odometer reading at the last look at the local graph."""
        self.tries = 0
        """Ways given up since the last node."""
        self.handled: list[tuple[float, float, float]] = []
        """Nodes just handled: x, y and the odometer reading (m) up to which they hide others."""
        self.doubts: list[tuple[float, float]] = []
        """Where on this edge a node was looked for in vain."""
        self.blocked = False
        """Whether the last command was stopped."""
        self._since_ns = self._free_ns = 0

    def begin(self, odom: OdometrySample) -> None:
        """Begin a step."""
        self.pose, self.stamp_ns = odom.base_in_odom, odom.stamp_ns
        self.trail.advance(self.pose.x, self.pose.y)

    def end(self, *, blocked: bool) -> None:
        """End a step whose command was stopped or not."""
        self.blocked = blocked
        if not blocked:
            self._free_ns = self.stamp_ns

    def enter(self, state: GvgState) -> None:
        """Change over to a state; a traversal that has not arrived when the robot leaves its edge is lost."""
        if self.announcements.traversing and state not in ON_EDGE:
            self.announcements.lose()
        self.state, self._since_ns, self._free_ns = state, self.stamp_ns, self.stamp_ns
        self.course = None

    def lose(self) -> None:
        """Give up what was under way, traversal or goal."""
        self.announcements.lose()
        self.enter(GvgState.IDLE)

    def waited_s(self) -> float:
        """Return the time since the present state was entered."""
        return (self.stamp_ns - self._since_ns) * 1e-9

    def blocked_s(self) -> float:
        """Return for how long all commands of the present state have been stopped."""
        return (self.stamp_ns - self._free_ns) * 1e-9

    def stuck(self) -> bool:
        """Whether the present state has no hope left."""
        return self.blocked_s() > STUCK_S or self.waited_s() > 10.0 * STUCK_S

    def pace(self, share: float) -> float:
        """Return a share of the cruising speed (m/s)."""
        return share * self.config.cruise_m_s

    def aim(self) -> ReducedNode:
        """Return the node homed on."""
        if self.target is None:
            raise GvgError(f"no node to home on while {self.state.value}")
        return self.target

    def distance_m(self, x: float, y: float) -> float:
        """Return the distance to a place."""
        return math.hypot(x - self.pose.x, y - self.pose.y)

    def local_graph(self) -> ReducedGraph:
        """Return the reduced GVG round the robot as the map has it now."""
        return self.detector.graph(self.map.points(), self.pose.x, self.pose.y)

    def ways(self) -> tuple[float, ...]:
        """Return the directions (rad) in which the GVG leads on from here."""
        return self.local_graph().passing(self.pose.x, self.pose.y)
