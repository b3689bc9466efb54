"""The GVG level along the local graph: one object that a node, a bag loop or a simulation steps.

Odometry and scans, or sweeps of sonars, go in, a command and events come out.  What is seen or heard becomes a local
map, the map a local reduced graph, and the robot follows its branches; nodes are decided by the truth's own rules.
"""

import math

from hslam_gvg.driving.doing import Accessing, GoingStraight, Idle, Turning
from hslam_gvg.driving.driver import Driver
from hslam_gvg.driving.handled import Handled
from hslam_gvg.driving.now import Now
from hslam_gvg.driving.surroundings import surroundings
from hslam_gvg.driving.traversal import Traversal
from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.guards.ring_guard import RingGuardConfig
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_gvg.states import GvgError, GvgOutput, GvgState
from hslam_types.gvg_events import GoalKind, GvgGoal, NodeView
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import OdometrySample, RangeScan, SonarSweep, Velocity


class GraphFollower:
    """Follows the local graph, finds its nodes and announces them."""

    def __init__(
        self,
        config: FollowConfig | None = None,
        mapping: ScanMapConfig | SonarMapConfig | None = None,
        graph: LocalGraphConfig | None = None,
        guard: RingGuardConfig | None = None,
    ) -> None:
        """Start idle, knowing nothing; ``mapping`` tells by what sensor the map is drawn."""
        self.config = config or FollowConfig()
        self._mapping, self._graph = mapping or ScanMapConfig(), graph or LocalGraphConfig()
        self._guard = guard or RingGuardConfig()
        self._traversal = Traversal()
        self._stamp_ns = 0
        self._heard_ns: int | None = None
        """When a scan came last."""
        self._lost = False
        """Whether a reset has ended what the next step is to announce as lost."""
        self._forget()

    def _forget(self) -> None:
        self._around = surroundings(self.config, self._mapping, self._graph, self._guard)
        self._handled, self._driver = Handled(), Driver()
        self.next_goal: GvgGoal | None = None
        """Goal taken but not begun."""
        self._decided_ns: int | None = None

    @property
    def node(self) -> NodeView | None:
        """The node the robot stands at, from its arrival to its departure."""
        doing = self._driver.doing
        if not isinstance(doing, Idle | Turning) or doing.at is None:
            return None
        return doing.at.view.moved(self._around.map_in_odom)

    @property
    def map_in_odom(self) -> SE2:
        """The frame of the local map in odom: how the map has corrected what odometry says."""
        return self._around.map_in_odom

    @property
    def room_m(self) -> float:
        """The clearance where the robot is."""
        return self._around.clearance(self._around.pose.x, self._around.pose.y)

    @property
    def path_length_m(self) -> float:
        """The length of the traversal under way, so far; 0 without one."""
        return self._traversal.length_m if self._traversal.leg is not None else 0.0

    @property
    def distance_left_m(self) -> float:
        """The way left to the target of a straight drive; 0 without one."""
        doing, pose = self._driver.doing, self._around.pose
        return math.hypot(doing.x - pose.x, doing.y - pose.y) if isinstance(doing, GoingStraight) else 0.0

    def obstacle_points(self) -> Array:
        """Return the obstacle points of the local map, n x 2 (m, odom)."""
        return self._around.points_in_odom()

    def reset(self) -> None:
        """Forget the local map, the node and the goal, and stand still; what was under way is announced as lost."""
        busy = self._driver.kind is not GvgState.IDLE or self._traversal.leg is not None or self.next_goal is not None
        self._lost |= busy
        self._forget()

    def start(self, goal: GvgGoal, decided_ns: int | None = None) -> None:
        """Take a goal, which the next step begins; raises GvgError for one that cannot be carried out from here.

        ``decided_ns`` is the cycle whose events led to the goal, if it was one's: the goal is then begun in the second
        cycle after, however early it comes, so that the run is the same every time.
        """
        if goal.kind is GoalKind.TRACE:
            self._turning_to(goal.branch)
        elif goal.kind is GoalKind.STRAIGHT and not (math.isfinite(goal.x_in_odom) and math.isfinite(goal.y_in_odom)):
            raise GvgError(f"cannot drive to ({goal.x_in_odom}, {goal.y_in_odom}): the target must be finite")
        self.next_goal, self._decided_ns = goal, decided_ns

    def step(self, odom: OdometrySample, heard: RangeScan | SonarSweep | None) -> GvgOutput:
        """Take one cycle's inputs and return the command and what there is to announce; a cycle may have no scan."""
        traversal, around, driver = self._traversal, self._around, self._driver
        early_ns, self._stamp_ns = self._stamp_ns, odom.stamp_ns
        traversal.begin_step(odom.stamp_ns)
        if self._lost:
            self._lost = False
            traversal.lose()
        dropped = self._begin_goal(early_ns)
        around.move(odom.base_in_odom)
        along = around.step_m if driver.kind is GvgState.TRACING else 0.0
        around.hear(heard, odom, attentive=driver.attentive)
        traversal.advance(around.pose.x, around.pose.y, along)
        now = Now(odom.stamp_ns, around, traversal, self._handled, self.config)
        if heard is not None or self._heard_ns is None:
            self._heard_ns = odom.stamp_ns
        is_blind = now.since_s(self._heard_ns) > self.config.blind_s
        command = Velocity() if is_blind else driver.step(odom, now)
        return GvgOutput(
            command, tuple(event.moved(around.map_in_odom) for event in traversal.events), driver.kind, dropped
        )

    def _begin_goal(self, last_ns: int) -> str:
        """Begin the goal taken, unless its time comes later; return why it cannot be begun, empty if it can."""
        goal = self.next_goal
        if goal is None or (self._decided_ns is not None and last_ns <= self._decided_ns):
            return ""
        self.next_goal = None
        if goal.kind is GoalKind.TRACE:
            try:
                self._driver.begin(self._turning_to(goal.branch))
            except GvgError as error:
                return str(error)
            return ""
        self._traversal.give_up()
        if goal.kind is GoalKind.ACCESS:
            self._driver.begin(Accessing(self._stamp_ns, self._around.turned, goal.heading_in_odom))
        elif goal.kind is GoalKind.STRAIGHT:
            self._driver.begin(GoingStraight(*self._around.in_map(goal.x_in_odom, goal.y_in_odom)))
        else:
            doing = self._driver.doing
            self._driver.begin(doing if isinstance(doing, Idle) else Idle())
        return ""

    def _turning_to(self, branch: int) -> Turning:
        """Return the turn to a branch of the node stood at; raises GvgError where there is none."""
        doing = self._driver.doing
        if not isinstance(doing, Idle | Turning) or doing.at is None:
            raise GvgError("cannot trace an edge: the robot is at no node (give the goal 'access' first)")
        if not 0 <= branch < doing.at.view.degree:
            raise GvgError(f"the node has no branch {branch}, only 0 to {doing.at.view.degree - 1}")
        return Turning(doing.at, branch, self._stamp_ns)
