"""The GVG level of a robot that somebody else drives: it tells the nodes and edges passed, and commands nothing.

The robot may be anywhere between the walls: a node's place is that of the meet point in the local map, relative to the
robot, and an edge leads from meet point to meet point.
"""

import math
from itertools import pairwise

from hslam_gvg.driving.surroundings import surroundings
from hslam_gvg.driving.traversal import Leg, Traversal
from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.guards.ring_guard import RingGuardConfig
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.local_graph.local_graph import LocalGraph
from hslam_gvg.local_graph.node_view import node_view
from hslam_gvg.local_graph.polyline import length_m
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_gvg.states import GvgError, GvgOutput, GvgState
from hslam_gvg.watching.passages import NODE_CLEARANCES, NODE_M, TAKEN_M, Passage, passages
from hslam_types.gvg_events import GvgGoal, NodeView
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import OdometrySample, RangeScan, SonarSweep, Velocity
from hslam_voronoi.branch_graph import Hub

SAME_M, SAME_CLEARANCES = 0.5, 0.6
"""Two looks show one node where they have it no farther apart."""
FRESH_M = 1.2
"""So much farther on than a passage can be told, some looks have told it."""
REMEMBERED_M = 12.0
"""Of a longer trail the beginning is left out: the local map has forgotten what was there."""


class GraphWatcher:
    """A `hslam_gvg.level.GvgLevel` that takes no goals."""

    def __init__(
        self,
        config: FollowConfig | None = None,
        mapping: ScanMapConfig | SonarMapConfig | None = None,
        graph: LocalGraphConfig | None = None,
        guard: RingGuardConfig | None = None,
    ) -> None:
        """Start knowing nothing; ``mapping`` tells by what sensor the map is drawn."""
        self._config = config or FollowConfig()
        self._settings = mapping or ScanMapConfig(), graph or LocalGraphConfig(), guard or RingGuardConfig()
        self._traversal = Traversal()
        self._lost = False
        self._forget()

    def _forget(self) -> None:
        self._around = surroundings(self._config, *self._settings)
        self._suspected: Hub | None = None
        """The node that the last look saw passed: the next one shall see it too."""
        self.next_goal: GvgGoal | None = None

    @property
    def node(self) -> NodeView | None:
        """None: a robot that is not stopped at nodes is never at one."""
        return None

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
        """0: there are no straight drives."""
        return 0.0

    def obstacle_points(self) -> Array:
        """Return the obstacle points of the local map, n x 2 (m, odom)."""
        return self._around.points_in_odom()

    def reset(self) -> None:
        """Forget the local map; what was under way is announced as lost."""
        self._lost |= self._traversal.leg is not None
        self._forget()

    def start(self, goal: GvgGoal, decided_ns: int | None = None) -> None:
        """Raise GvgError: nobody is obeyed."""
        del decided_ns
        raise GvgError(f"goal {goal.kind.value} refused: somebody else drives this robot (parameter drive)")

    def step(self, odom: OdometrySample, heard: RangeScan | SonarSweep | None) -> GvgOutput:
        """Take one cycle's inputs and return what there is to announce; the command is to stand, for who asks."""
        traversal, around = self._traversal, self._around
        traversal.begin_step(odom.stamp_ns)
        if self._lost:
            self._lost = False
            traversal.lose()
        around.move(odom.base_in_odom)
        around.hear(heard, odom, attentive=False)
        traversal.advance(around.pose.x, around.pose.y, around.step_m)
        if around.look_is_due():
            around.look()
            if around.graph is not None:
                self._announce(around.graph)
        return GvgOutput(
            Velocity(), tuple(event.moved(around.map_in_odom) for event in traversal.events), GvgState.WATCHING
        )

    def _announce(self, graph: LocalGraph) -> None:
        """Announce what was passed since the last departure, once two looks have seen it."""
        traversal = self._traversal
        if traversal.leg is None:
            traversal.access()
            return
        trail = traversal.back(REMEMBERED_M)[::-1]
        found = passages(graph, trail) if len(trail) > 1 else []
        if found is None:
            traversal.lose()
            self._suspected = None
            return
        found = [passage for passage in found if self._is_fresh(graph.hub(passage.node), trail[passage.at :])]
        if found and self._is_departure(graph.hub(found[0].node), trail[: found[0].at + 1]):
            found = found[1:]
        suspected = self._suspected
        self._suspected = graph.hub(found[0].node) if found else None
        if suspected is None or self._suspected is None or not _is_same(suspected, self._suspected):
            return
        self._suspected = None
        for passage in found:
            self._pass(graph, passage, trail)

    def _is_fresh(self, hub: Hub, since: Array) -> bool:
        """Whether a node was passed just now: one that shows only farther on is of walls that the map forgets."""
        return length_m(since) < max(NODE_M, NODE_CLEARANCES * hub.clearance) + TAKEN_M + FRESH_M

    def _is_departure(self, hub: Hub, way: Array) -> bool:
        """Whether a node is the one departed from, seen a little farther on: the way there never left it."""
        leg = self._traversal.leg
        if leg is None or leg.node is None:
            return False
        left = Hub(leg.node.x_in_odom, leg.node.y_in_odom, leg.node.clearance_m)
        reach_m = left.clearance + self._config.chord_m
        return _is_same(left, hub) and all(math.hypot(x - left.x, y - left.y) < reach_m for x, y, _ in way)

    def _pass(self, graph: LocalGraph, passage: Passage, trail: Array) -> None:
        """Announce the arrival at a node passed, and the departure from it."""
        hub, paths = graph.hub(passage.node), [way.path for way in graph.ways(passage.node)]
        view, ordered = node_view(hub, paths, self._config.chord_m)
        came, left = (next(i for i, path in enumerate(ordered) if path is paths[way]) for way in passage[1:3])
        self._traversal.cut(len(trail) - 1 - passage.at)
        self._traversal.arrive(view, came)
        self._traversal.depart(Leg(view, left, ordered))
        since = trail[passage.at :]
        for (x0, y0, _), (x, y, _) in pairwise(since):
            self._traversal.advance(float(x), float(y), math.hypot(x - x0, y - y0))


def _is_same(hub: Hub, other: Hub) -> bool:
    apart_m = math.hypot(hub.x - other.x, hub.y - other.y)
    return apart_m < max(SAME_M, SAME_CLEARANCES * max(hub.clearance, other.clearance))
