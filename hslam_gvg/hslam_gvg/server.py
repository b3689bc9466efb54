"""The GVG level: one object that a node, a bag loop or a simulation steps.

Odometry and sonar go in, a command and events come out.  The states are the control laws and what lies between
them: access, trace, home, probe, verify.
"""

import math
from dataclasses import dataclass
from enum import Enum

from hslam_gvg.caution import Caution
from hslam_gvg.closest_points import ahead, beside, closest_points
from hslam_gvg.config import GvgConfig
from hslam_gvg.control import access, drive, follow, trace
from hslam_gvg.journey import Journey
from hslam_gvg.motion import go_to, turn_to
from hslam_gvg.node_detector import NodeDetector
from hslam_gvg.obstacle_map import ObstacleMap
from hslam_gvg.probe import Probe
from hslam_gvg.reduced_graph import ReducedNode
from hslam_gvg.safety import Reflex
from hslam_gvg.stall import StallWatch
from hslam_gvg.trail import Trail
from hslam_types.errors import HslamError
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind, NodeView
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import OdometrySample, SonarSweep, Velocity

ALIGNED = math.radians(3.0)
ACCESS_TOLERANCE_M = 0.1
FIRST_SWEEP_S = 1.2
SAME_NODE_M = 0.8
STUCK_S = 4.0
SECOND_LOOKS = 2
SECOND_LOOK_M = 1.0
COURSE_BACK_M = 1.0
OPENING, SLOWING, SLOWEST = 1.12, 2.5, 0.2
"""Where the clearance grows by more than a factor a side opens: slower, the edge at its far end answers seldom."""
WIDER, NARROWER = 0.006, 0.05
"""Shares of the usual clearance renewed at each step."""
NOT_BACK = math.radians(60.0)
LEAVING_M = 1.0
SHARPEST_TURN = math.radians(120.0)
TRIES = 3
BACKING_S = 2.0
LEAF_M = 1.5
LEAST_EDGE_M = 1.0


class GvgError(HslamError):
    """A goal cannot be taken as things stand."""


class GvgState(Enum):
    """What the robot is doing."""

    IDLE = "idle"
    LISTENING = "listening"
    ACCESSING = "accessing"
    TURNING = "turning"
    TRACING = "tracing"
    HOMING = "homing"
    PROBING = "probing"
    SETTLING = "settling"
    RESUMING = "resuming"
    BACKING = "backing"
    RECOILING = "recoiling"
    STRAIGHT = "straight"


@dataclass(frozen=True, slots=True)
class GvgOutput:
    """The answer to one step."""

    command: Velocity
    events: tuple[GvgEvent, ...]
    state: GvgState


class GvgServer:
    """Follows the GVG by sonar, finds its nodes and announces them."""

    def __init__(self, config: GvgConfig | None = None) -> None:
        """Start idle, knowing nothing."""
        self.config = config = config or GvgConfig()
        self.map = ObstacleMap(config)
        self.node: NodeView | None = None
        """The node the robot stands at, from its arrival to its departure."""
        self._reflex, self._caution, self._stall, self._trail = Reflex(config), Caution(config), StallWatch(), Trail()
        self._interrupted = GvgState.IDLE
        self._back_to = (0.0, 0.0)
        self._detector = NodeDetector(config)
        self._journey = Journey()
        self._state = GvgState.IDLE
        self._handlers = {
            GvgState.IDLE: self._idle,
            GvgState.LISTENING: self._listen,
            GvgState.ACCESSING: self._access,
            GvgState.TURNING: self._turn,
            GvgState.TRACING: self._trace,
            GvgState.HOMING: self._home,
            GvgState.PROBING: self._probe,
            GvgState.SETTLING: self._settle,
            GvgState.RESUMING: self._resume,
            GvgState.BACKING: self._back_off,
            GvgState.RECOILING: self._recoil,
            GvgState.STRAIGHT: self._straight,
        }
        self._pose, self._stamp_ns, self._since_ns = SE2(), 0, 0
        self._before: OdometrySample | None = None
        self._events: list[GvgEvent] = []
        self._sequence = 0
        self._branch = -1
        self._heading = 0.0
        self._course: float | None = None
        self._room = config.wide_m
        self._looked_m = 0.0
        self._target: ReducedNode | None = None
        self._plan = Probe(())
        self._tries = 0
        self._handled: list[tuple[float, float, float]] = []
        self._obstructions: list[tuple[float, float, float, float]] = []
        self._doubts: list[tuple[float, float]] = []
        self._goal = (0.0, 0.0)
        self._blocked_ns = 0

    def start(self, goal: GvgGoal) -> None:
        """Take a goal; raises GvgError for a branch that the node stood at does not have."""
        if goal.kind == GoalKind.TRACE:
            if self.node is None:
                raise GvgError("cannot trace an edge: the robot is at no node (give the goal 'access' first)")
            if not 0 <= goal.branch < self.node.degree:
                raise GvgError(f"the node has no branch {goal.branch}, only 0 to {self.node.degree - 1}")
            self._branch = goal.branch
            self._enter(GvgState.TURNING)
        elif goal.kind == GoalKind.ACCESS:
            self.node = None
            self._enter(GvgState.LISTENING)
        elif goal.kind == GoalKind.STRAIGHT:
            self.node = None
            self._goal = (goal.x_in_odom, goal.y_in_odom)
            self._enter(GvgState.STRAIGHT)
        else:
            self._enter(GvgState.IDLE)

    def step(self, odom: OdometrySample, sonar: SonarSweep) -> GvgOutput:
        """Take one cycle's inputs and return the command and what there is to announce."""
        self._pose, self._stamp_ns, self._events = odom.base_in_odom, odom.stamp_ns, []
        poses = tuple(self._pose_at(ping.stamp_ns, odom) for ping in sonar.pings)
        self._before = odom
        self.map.move(self._pose)
        self.map.hear(sonar, poses)
        self._reflex.hear(sonar, poses)
        self._caution.hear(sonar, poses)
        self._stall.see(odom)
        self._trail.advance(self._pose.x, self._pose.y)
        if self._stall.stalled:
            self._touched()
        wanted = self._handlers[self._state]()
        wanted = self._caution.limit(wanted, self._pose, self.map.suspects(), self._trail)
        command = self._reflex.limit(wanted, self._pose)
        self._stall.tell(command)
        if not self._is_blocked():
            self._blocked_ns = self._stamp_ns
        return GvgOutput(command, tuple(self._events), self._state)

    # States.

    def _idle(self) -> Velocity:
        return Velocity()

    def _listen(self) -> Velocity:
        """Wait for a first full sweep before moving."""
        if self._waited_s() >= FIRST_SWEEP_S:
            self._tries = 0
            self._enter(GvgState.ACCESSING)
        return Velocity()

    def _access(self) -> Velocity:
        x, y, _ = self._pose
        near = closest_points(self.map.points(), x, y, self.config.reach_m, self.config.separation, most=2)
        if not near:
            return Velocity(self.config.cruise_m_s * 0.5, 0.0)
        wide = near[0].distance_m >= self.config.wide_m
        self._room = min(near[0].distance_m, self.config.wide_m)
        if wide or (len(near) > 1 and near[1].distance_m - near[0].distance_m < ACCESS_TOLERANCE_M) or self._stuck():
            return self._accessed()
        return drive(
            self._pose,
            *access(near[0], self._pace(0.5)),
            self.config.turn_rad_s,
            backwards=self._is_behind(near[0].bearing),
        )

    def _accessed(self) -> Velocity:
        """Announce the GVG and follow it the way that is nearer to the heading."""
        x, y, heading = self._pose
        ways = self._detector.graph(self.map.points(), x, y).passing(x, y)
        self._heading = min(self._unobstructed(ways) or ways, key=lambda way: abs(wrap(way - heading)), default=heading)
        self._journey.begin(x, y)
        self._announce(EventKind.ACCESS)
        self._enter(GvgState.RESUMING)
        return Velocity()

    def _turn(self) -> Velocity:
        """Turn on the spot to the branch to depart by."""
        if self.node is None:
            raise GvgError("the node to depart from is gone: give the goal 'access'")
        bearing = self.node.bearings_in_odom[self._branch]
        if abs(wrap(bearing - self._pose.theta)) > ALIGNED:
            return turn_to(self._pose, bearing, self.config.turn_rad_s)
        self._announce(EventKind.DEPARTURE, self.node, self._branch)
        self._handled = [(self.node.x_in_odom, self.node.y_in_odom, self.map.travel_m + self.config.suppress_travel_m)]
        self._doubts.clear()
        self.node = None
        self._heading = bearing
        self._journey.begin(self._pose.x, self._pose.y)
        self._tries = 0
        self._enter(GvgState.TRACING)
        return Velocity()

    def _resume(self) -> Velocity:
        """Turn on the spot to go on along the edge under way."""
        if abs(wrap(self._heading - self._pose.theta)) > ALIGNED:
            return turn_to(self._pose, self._heading, self.config.turn_rad_s)
        self._journey.resume(self._pose.x, self._pose.y)
        self._enter(GvgState.TRACING)
        return Velocity()

    def _trace(self) -> Velocity:
        """Follow two-way equidistance; look for nodes every so often, and at once where the way is blocked."""
        x, y, _ = self._pose
        self._journey.advance(x, y)
        stopped = self._blocked_s() > 1.0
        if stopped or self.map.travel_m - self._looked_m >= self.config.look_every_m:
            self._looked_m = self.map.travel_m
            if self._look():
                return Velocity()
        if self._blocked_s() > STUCK_S:
            return self._give_way()
        return self._follow_edge()

    def _way_on(self, ways: tuple[float, ...]) -> float | None:
        """Return the direction in which the local graph leads on: the one nearest to the heading, but not back."""
        x, y, heading = self._pose
        back = self._journey.came_from(x, y, COURSE_BACK_M)
        on = [way for way in ways if back is None or abs(wrap(way - back)) > NOT_BACK]
        return min(on, key=lambda way: abs(wrap(way - heading)), default=None)

    def _follow_edge(self) -> Velocity:
        x, y, heading = self._pose
        if self._course is not None and abs(wrap(self._course - heading)) < SHARPEST_TURN:
            # Seen along the way the graph takes, a wall across the end of a corridor is on one side, not ahead.
            heading = self._course
        config, points = self.config, self.map.suspects()
        left, right = beside(points, x, y, heading, config.reach_m)
        open_m = ahead(points, x, y, heading, 0.3, 2.0)
        speed = config.cruise_m_s * min(1.0, max(0.35, open_m / 1.6))
        room = min((c.distance_m for c in (left, right) if c is not None), default=config.wide_m)
        speed *= min(1.0, max(SLOWEST, 1.0 - SLOWING * (room / self._room - OPENING)))
        self._room += (WIDER if room > self._room else NARROWER) * (room - self._room)
        wide = config.wide_m
        if left is not None and right is not None and min(left.distance_m, right.distance_m) < wide:
            v = trace(left, right, heading, speed, config.equidistance_gain)
        elif left is not None or right is not None:
            wall = min((c for c in (left, right) if c is not None), key=lambda c: c.distance_m)
            v = follow(wall, wide, heading, speed, config.equidistance_gain)
        else:
            v = speed * math.cos(heading), speed * math.sin(heading)
        return self._steer(v, speed)

    def _steer(self, v: tuple[float, float], speed: float) -> Velocity:
        size = math.hypot(*v)
        share = min(1.0, speed / max(size, 1e-9))
        return drive(self._pose, v[0] * share, v[1] * share, self.config.turn_rad_s)

    def _look(self) -> bool:
        """Look at the local graph for a node on the recent path; begin homing on it."""
        x, y, _ = self._pose
        points = self.map.points()
        self._handled = [h for h in self._handled if self.map.travel_m < h[2]]
        graph = self._detector.graph(points, x, y)
        # At the node just left every branch passes by; which one was meant is what the departure said.
        leaving = self._journey.length_m < LEAVING_M
        self._course = self._heading if leaving else self._way_on(graph.passing(x, y))
        node = self._detector.passed(graph, self._pose, self._journey.places(), [h[:2] for h in self._handled])
        if node is None:
            return False
        self._target = self._detector.homed(points, node)
        self._journey.rewind(node.x, node.y)
        self._heading = self._pose.theta
        self._tries = 0
        self._enter(GvgState.HOMING)
        return True

    def _home(self) -> Velocity:
        """Drive to the node as the map has it, and once there ask the map again."""
        target = self._aim()
        if self._distance(target) > self.config.home_tolerance_m and not self._stuck():
            return go_to(self._pose, target.x, target.y, self._pace(0.8), self.config.turn_rad_s)
        return self._confirm(GvgState.PROBING)

    def _settle(self) -> Velocity:
        """After probing: drive to the node's refined place and announce it."""
        target = self._aim()
        if self._distance(target) > self.config.home_tolerance_m and not self._stuck():
            return go_to(self._pose, target.x, target.y, self._pace(0.8), self.config.turn_rad_s)
        return self._arrive(target)

    def _probe(self) -> Velocity:
        """Step along each edge and back, so that the map shows what the node's middle hides."""
        command = self._plan.step(
            self._pose, self._stamp_ns, self._pace(0.8), self.config.turn_rad_s, self._is_blocked()
        )
        return command if command is not None else self._confirm(GvgState.SETTLING)

    def _confirm(self, then: GvgState) -> Velocity:
        """Look again at the node: is it still one, and where exactly?"""
        aim = self._aim()
        x, y = aim.x, aim.y
        points = self.map.points()
        graph = self._detector.graph(points, x, y)
        node = graph.node_near(x, y, SAME_NODE_M)
        if node is None:
            self._weak(graph.passing(x, y))
            return Velocity()
        self._target = self._detector.homed(points, node)
        if then == GvgState.PROBING:
            self._plan = Probe.along(self._target, self._pose, self.config.probe_m)
        self._enter(then)
        return Velocity()

    def _weak(self, ways: tuple[float, ...]) -> None:
        """No strong node after all: go on along the edge that does not lead back."""
        aim = self._aim()
        x, y = aim.x, aim.y
        # From a little farther on the map may tell better; but not for ever.
        again = sum(math.hypot(x - dx, y - dy) < self.config.suppress_m for dx, dy in self._doubts) < SECOND_LOOKS
        hidden_m = SECOND_LOOK_M if again else self.config.suppress_travel_m
        self._handled.append((x, y, self.map.travel_m + hidden_m))
        self._doubts.append((x, y))
        back = self._journey.came_from(x, y, self.config.chord_m)
        if ways and back is not None:
            self._heading = max(ways, key=lambda way: abs(wrap(way - back)))
        self._target = None
        self._looked_m = self.map.travel_m
        self._enter(GvgState.RESUMING)

    def _arrive(self, node: ReducedNode) -> Velocity:
        kind = NodeKind.BOUNDARY_POINT if node.degree == 1 else NodeKind.MEET_POINT
        self.node = NodeView(kind, node.x, node.y, node.clearance_m, node.bearings)
        back = self._journey.came_from(node.x, node.y, self.config.chord_m)
        branch = -1 if back is None else self.node.nearest_branch(back)
        self._announce(EventKind.ARRIVAL, self.node, branch, self._journey.length_m)
        self._target = None
        self._enter(GvgState.IDLE)
        return Velocity()

    def _give_way(self) -> Velocity:
        """Blocked while tracing: home on the dead end if the map shows one, else step back to choose again."""
        x, y, heading = self._pose
        leaf = self._detector.graph(self.map.points(), x, y).node_near(x, y, LEAF_M)
        self._obstructions.append((x, y, heading, self.map.travel_m + self.config.suppress_travel_m))
        self._tries += 1
        if leaf is not None and leaf.degree == 1 and self._tries == 1:
            self._target = leaf
            self._enter(GvgState.HOMING)
        else:
            self._enter(GvgState.BACKING)
        return Velocity()

    def _back_off(self) -> Velocity:
        """Step back from what blocks the way, then take one that is not blocked."""
        if self._waited_s() < BACKING_S and not self._is_blocked():
            return Velocity(-self._pace(0.5), 0.0)
        self._go_another_way()
        return Velocity()

    def _go_another_way(self) -> None:
        """Take a way that is not blocked; where none is left, the edge ends."""
        x, y, heading = self._pose
        ways = self._detector.graph(self.map.points(), x, y).passing(x, y)
        back = self._journey.came_from(x, y, self.config.chord_m)
        on = [w for w in self._unobstructed(ways) if back is None or abs(wrap(w - back)) > NOT_BACK]
        if on and self._tries <= TRIES:
            self._heading = min(on, key=lambda way: abs(wrap(way - heading)))
            self._enter(GvgState.RESUMING)
        elif back is not None and self._journey.length_m > LEAST_EDGE_M:
            near = closest_points(self.map.points(), x, y, self.config.reach_m, self.config.separation, most=1)
            clearance_m = near[0].distance_m if near else self.config.crawl_m
            self._arrive(ReducedNode(x, y, clearance_m, (back,)))
        else:
            self._announce(EventKind.LOST)
            self._enter(GvgState.IDLE)

    def _unobstructed(self, ways: tuple[float, ...]) -> list[float]:
        """Return the ways that have not just proved blocked from about here."""
        x, y, _ = self._pose
        self._obstructions = [o for o in self._obstructions if self.map.travel_m < o[3]]
        near = [o[2] for o in self._obstructions if math.hypot(o[0] - x, o[1] - y) < SAME_NODE_M]
        return [way for way in ways if all(abs(wrap(way - blocked)) > NOT_BACK for blocked in near)]

    def _straight(self) -> Velocity:
        """Drive to a point; idle when there, lost when something stands in the way."""
        x, y = self._goal
        if math.hypot(x - self._pose.x, y - self._pose.y) <= self.config.home_tolerance_m:
            self._enter(GvgState.IDLE)
            return Velocity()
        if self._blocked_s() > STUCK_S:
            self._announce(EventKind.LOST)
            self._enter(GvgState.IDLE)
            return Velocity()
        return go_to(self._pose, x, y, self._pace(0.8), self.config.turn_rad_s)

    def _touched(self) -> None:
        """Something holds the body: remember it there and go back the way that led here."""
        x, y, heading = self._pose
        way = heading if self._stall.direction > 0.0 else wrap(heading + math.pi)
        self.map.touch(self._pose, self._stall.direction)
        self._obstructions.append((x, y, way, self.map.travel_m + self.config.suppress_travel_m))
        self._stall = StallWatch()
        if self._state != GvgState.RECOILING:
            self._interrupted = self._state
            self._back_to = self._trail.before(self._pose.x, self._pose.y, self.config.recoil_m)
            self._enter(GvgState.RECOILING)
        else:
            self._recoiled()

    def _recoil(self) -> Velocity:
        """Drive back along the trail, then let what was under way take note."""
        x, y = self._back_to
        there = math.hypot(x - self._pose.x, y - self._pose.y) <= 2.0 * self.config.home_tolerance_m
        if there or self._stuck():
            self._recoiled()
            return Velocity()
        return go_to(self._pose, x, y, self._pace(0.5), self.config.turn_rad_s)

    def _recoiled(self) -> None:
        state = self._interrupted
        if state == GvgState.HOMING:
            self._confirm(GvgState.PROBING)
        elif state == GvgState.SETTLING:
            self._arrive(self._aim())
        elif state == GvgState.PROBING:
            self._plan.skip()
            self._enter(GvgState.PROBING)
        elif state == GvgState.STRAIGHT:
            self._announce(EventKind.LOST)
            self._enter(GvgState.IDLE)
        elif state == GvgState.ACCESSING:
            self._enter(GvgState.ACCESSING)
        else:
            self._tries += 1
            self._go_another_way()

    # What the states share.

    def _aim(self) -> ReducedNode:
        """Return the node homed on."""
        if self._target is None:
            raise GvgError(f"no node to home on while {self._state.value}")
        return self._target

    def _enter(self, state: GvgState) -> None:
        self._state, self._since_ns, self._blocked_ns = state, self._stamp_ns, self._stamp_ns
        self._course = None

    def _announce(self, kind: EventKind, node: NodeView | None = None, branch: int = -1, length_m: float = 0.0) -> None:
        self._events.append(GvgEvent(self._sequence, self._stamp_ns, kind, node, branch, length_m))
        self._sequence += 1

    def _is_blocked(self) -> bool:
        return self._reflex.blocked or self._caution.blocked

    def _waited_s(self) -> float:
        return (self._stamp_ns - self._since_ns) * 1e-9

    def _blocked_s(self) -> float:
        return (self._stamp_ns - self._blocked_ns) * 1e-9

    def _stuck(self) -> bool:
        return self._blocked_s() > STUCK_S or self._waited_s() > 10.0 * STUCK_S

    def _pace(self, share: float) -> float:
        return share * self.config.cruise_m_s

    def _distance(self, node: ReducedNode) -> float:
        return math.hypot(node.x - self._pose.x, node.y - self._pose.y)

    def _is_behind(self, obstacle_bearing: float) -> bool:
        """Whether moving away from an obstacle means moving backwards."""
        return abs(wrap(obstacle_bearing - self._pose.theta)) < 0.5 * math.pi

    def _pose_at(self, stamp_ns: int, now: OdometrySample) -> SE2:
        """Return base_link in odom at a time between the last two samples."""
        last = self._before
        if last is None or stamp_ns >= now.stamp_ns or last.stamp_ns >= now.stamp_ns:
            return now.base_in_odom
        share = max(0.0, (stamp_ns - last.stamp_ns) / (now.stamp_ns - last.stamp_ns))
        a, b = last.base_in_odom, now.base_in_odom
        return SE2(
            a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), wrap(a.theta + share * wrap(b.theta - a.theta))
        )
