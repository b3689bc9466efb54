"""The GVG level: one object that a node, a bag loop or a simulation steps.

Odometry and sonar go in, a command and events come out.  `GvgServer.step` is the whole of it: map what is heard, let
the state at hand say where to (access, trace, home, probe), bound that by what is known to be safe.
"""

from collections.abc import Callable

from hslam_gvg.accessing import Accessing
from hslam_gvg.caution import ONE, SEVERAL, Caution
from hslam_gvg.config import GvgConfig
from hslam_gvg.departing import Departing
from hslam_gvg.homing import Homing
from hslam_gvg.obstacle_map import ObstacleMap
from hslam_gvg.recovery import Recovery
from hslam_gvg.safety import Reflex
from hslam_gvg.situation import Situation
from hslam_gvg.stall import StallWatch
from hslam_gvg.states import GvgError, GvgOutput, GvgState
from hslam_gvg.straight import Straight
from hslam_gvg.tracing import Tracing
from hslam_types.gvg_events import GoalKind, GvgGoal, NodeView
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import OdometrySample, SonarSweep, Velocity

__all__ = ["GvgError", "GvgOutput", "GvgServer", "GvgState"]


class GvgServer:
    """Follows the GVG by sonar, finds its nodes and announces them."""

    def __init__(self, config: GvgConfig | None = None) -> None:
        """Start idle, knowing nothing."""
        self.config = config or GvgConfig()
        self._forget(Situation(self.config))

    def _forget(self, now: Situation) -> None:
        """Begin anew in a situation."""
        self._now, config = now, self.config
        self._reflex, self._caution, self._stall = Reflex(config), Caution(config), StallWatch()
        self._before: OdometrySample | None = None
        self.next_goal: GvgGoal | None = None
        """Goal taken but not begun."""
        self._decided_ns: int | None = None
        self._accessing, self._departing, self._homing = Accessing(now), Departing(now), Homing(now)
        self._recovery, self._straight = Recovery(now, self._homing), Straight(now)
        self._states: dict[GvgState, Callable[[], Velocity]] = {
            GvgState.IDLE: Velocity,
            GvgState.LISTENING: self._accessing.listen,
            GvgState.ACCESSING: self._accessing.climb,
            GvgState.TURNING: self._departing.turn,
            GvgState.TRACING: Tracing(now, self._recovery).follow,
            GvgState.HOMING: self._homing.home,
            GvgState.PROBING: self._homing.probe,
            GvgState.SETTLING: self._homing.settle,
            GvgState.RESUMING: self._departing.resume,
            GvgState.BACKING: self._recovery.back_off,
            GvgState.RECOILING: self._recovery.recoil,
            GvgState.STRAIGHT: self._straight.drive,
        }

    @property
    def map(self) -> ObstacleMap:
        """The local obstacle map, in odom."""
        return self._now.map

    @property
    def node(self) -> NodeView | None:
        """The node the robot stands at, from its arrival to its departure."""
        return self._now.node

    @property
    def map_in_odom(self) -> SE2:
        """The frame of the local map in odom: that of odom itself."""
        return SE2()

    @property
    def room_m(self) -> float:
        """The usual clearance where the robot is, as far as it matters: up to the `wide_m` of the configuration."""
        return self._now.room_m

    @property
    def path_length_m(self) -> float:
        """The length of the traversal under way, so far; 0 without one."""
        return self._now.journey.length_m if self._now.announcements.traversing else 0.0

    @property
    def distance_left_m(self) -> float:
        """The way left to the target of the last straight drive."""
        return self._straight.distance_left_m()

    def obstacle_points(self) -> Array:
        """Return the obstacle points of the local map, n x 2 (m, odom)."""
        return self._now.map.points()

    def reset(self) -> None:
        """Forget the local map, the node and the goal, and stand still.

        If a goal or a traversal was under way the next step announces LOST, so that nobody waits for its end; a goal
        given before that step is begun in the one after.
        """
        before, announcements = self._now, self._now.announcements
        if not announcements.untold and (before.state is not GvgState.IDLE or self.next_goal is not None):
            announcements.lose()
        now = Situation(self.config, announcements)
        now.stamp_ns = before.stamp_ns
        self._forget(now)

    def start(self, goal: GvgGoal, decided_ns: int | None = None) -> None:
        """Take a goal, which the next step begins; raises GvgError for one that cannot be carried out from here.

        ``decided_ns`` is the cycle whose events led to the goal, if it was one's: the goal is then begun in the second
        cycle after, however early it comes. So whoever decides may work on a cycle while the next is driven, and the
        run is the same every time.  Should the robot have left the node by then, the step drops the goal and says so.
        """
        if goal.kind is GoalKind.TRACE:
            self._departing.check(goal.branch)
        elif goal.kind is GoalKind.STRAIGHT:
            self._straight.check(goal.x_in_odom, goal.y_in_odom)
        self.next_goal, self._decided_ns = goal, decided_ns

    def step(self, odom: OdometrySample, sonar: SonarSweep) -> GvgOutput:
        """Take one cycle's inputs and return the command and what there is to announce."""
        dropped = self._begin_goal()
        now = self._now
        now.begin(odom)
        self._hear(odom, sonar)
        if self._stall.sees(odom):
            self._recovery.held(self._stall.direction)
        wanted = self._states[now.state]()
        command = self._safe(wanted)
        return GvgOutput(command, now.announcements.tell(odom.stamp_ns), now.state, dropped)

    def _begin_goal(self) -> str:
        """Begin the goal taken, unless its time comes later; return why it cannot be begun, empty if it can."""
        goal, now = self.next_goal, self._now
        early = self._decided_ns is not None and now.stamp_ns <= self._decided_ns
        # What has ended is announced in a step of its own, lest its end be taken for that of the goal to begin.
        if goal is None or early or now.announcements.untold:
            return ""
        if now.announcements.traversing and goal.kind is not GoalKind.TRACE:
            now.enter(GvgState.IDLE)
            self._stall.reset()
            return ""
        self.next_goal = None
        if goal.kind is GoalKind.TRACE:
            try:
                self._departing.choose(goal.branch)
            except GvgError as error:
                return str(error)
        elif goal.kind is GoalKind.ACCESS:
            now.node, self._accessing.way = None, goal.heading_in_odom
            now.enter(GvgState.LISTENING)
        elif goal.kind is GoalKind.STRAIGHT:
            self._straight.begin(goal.x_in_odom, goal.y_in_odom)
        else:
            now.enter(GvgState.IDLE)
        self._stall.reset()
        return ""

    def _hear(self, odom: OdometrySample, sonar: SonarSweep) -> None:
        """Put the pings, each from where it was fired, into the map and before the guards."""
        poses = tuple(self._pose_at(ping.stamp_ns, odom) for ping in sonar.pings)
        self._before = odom
        self._now.map.move(odom.base_in_odom)
        self._now.map.hear(sonar, poses)
        self._reflex.hear(sonar, poses)
        self._caution.hear(sonar, poses)

    def _safe(self, wanted: Velocity) -> Velocity:
        """Return the command that the map and the last echoes allow."""
        now = self._now
        # An echo in mid-air must not end an edge.
        witnesses = SEVERAL if now.state is GvgState.TRACING else ONE
        careful = self._caution.limit(wanted, now.pose, now.map.suspects(), now.trail, witnesses)
        command = self._reflex.limit(careful, now.pose)
        self._stall.tell(command)
        now.end(blocked=self._caution.blocked or self._reflex.blocked)
        return command

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
