"""Navigate: along the graph to the edge a point lies beside, off the graph where it is nearer than any obstacle.

The atlas is only read.  While it is in doubt where the robot is, that is found out first.  Close to the point the
robot's place is made sure of by the terminal edge-map.
"""

import math
from collections.abc import Iterator
from enum import Enum

from hslam_atlas.localisation.locator import Locator
from hslam_atlas.localisation.place import Place
from hslam_atlas.missions.approach import WATCHED_M, Approach, reached
from hslam_atlas.missions.both_ways import BothWays, both_ways
from hslam_atlas.missions.destination import AtNode, Destination, FromEnd, OnEdge, check, ends_of, otherwise
from hslam_atlas.missions.localise import Localise
from hslam_atlas.missions.mission import Decision, Happened, Sense
from hslam_atlas.routes import PER_NODE_M, outward
from hslam_atlas.state import AtlasState
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.se2 import wrap

_TRIES = 4
"""Times a point may be passed out of reach, or a straight drive end before it, until it is given up."""
_CORRECT_EVERY = 4
"""Cycles between two looks at the edge's map near the point."""


_TURNING_M = 6.0
"""What leaving an edge in its midst to turn round costs, in metres."""


class Progress(Enum):
    """How far the errand is."""

    UNDER_WAY = "under way"
    REACHED = "reached"
    UNREACHABLE = "unreachable"


class Navigate:
    """One errand after another: `go_to` takes the next, also while one is under way."""

    def __init__(
        self, state: AtlasState, locator: Locator | None = None, *, at: GvgEvent | None = None, waiting: bool = True
    ) -> None:
        """Begin without an errand, lost unless a locator knows better.

        ``at``: the arrival at the node the robot stands at; ``waiting``: whether the GVG level has nothing to do.
        """
        self._state = state
        self.locator = locator or Locator(state)
        self._search = Localise(state, self.locator)
        self.closed: set[int] = set()
        """Edges found blocked: they are gone round."""
        self.progress = Progress.REACHED
        self.why = ""
        """Why a destination is unreachable."""
        self.path_left_m = math.nan
        """Along the graph, from where the robot last decided."""
        self._destination: Destination | None = None
        self._arrival = at
        """The arrival at the node the robot stands at, None off the graph."""
        self._waiting = waiting
        self._turn_round = True
        """Whether it has yet to be seen if the errand is nearer the other way along the edge under way."""
        self._approach = Approach()
        place = self.place
        self._on = None if place is None or place.branch is None else self._edge(place.node, place.branch)
        """The edge the robot was last known to be on or beside."""
        self._straight: tuple[float, float] | None = None
        """The point driven straight to, in odom."""
        self._tries = self._cycle = self._began = 0
        self._traced: int | None = None
        """The edge under way from one of its nodes."""
        self._again = False
        """Whether the straight drive may be repeated from where it ends."""
        self._others: list[OnEdge] | None = None
        """The destination as the edges see it that meet its own, those still to be tried; None before it is asked."""

    def go_to(self, destination: Destination) -> None:
        """Take an errand in place of the last; raises DestinationError where there is no such place."""
        self._destination = check(destination, self._state.graph)
        self.progress, self.why = Progress.UNDER_WAY, ""
        self._approach, self._tries, self._others = Approach(), 0, None
        # At a node what was decided may still be undone.
        self._waiting |= self._straight is not None or self._arrival is not None
        self._straight, self._turn_round = None, True

    @property
    def doing(self) -> str:
        """See `Mission`."""
        if self.progress is not Progress.UNDER_WAY:
            return str(self.progress.value)
        return "localising" if self.place is None else "navigating"

    @property
    def place(self) -> Place | None:
        """Where the robot is, None while that is in doubt."""
        return self.locator.certain

    def step(self, happened: Happened) -> Decision:
        """Follow what happened; decide where the robot waits, or passes what it looks for."""
        self._hear(happened)
        self._cycle += 1
        goal = self._decide(happened.sense)
        if goal is not None:
            self._waiting = False
        return Decision(goal, self.progress is not Progress.UNDER_WAY)

    def refused(self) -> None:
        """Reach the graph anew."""
        self._arrival, self._waiting = None, True

    def _hear(self, happened: Happened) -> None:
        self.locator.hear(happened)
        for event in happened.events:
            self._waiting |= event.kind is EventKind.ARRIVAL or (
                event.kind is EventKind.LOST and self._straight is None
            )
            self._arrival = event if event.kind is EventKind.ARRIVAL else None
            if event.kind is EventKind.ARRIVAL:
                self._approach = Approach()
                self._close_blocked()
                self._count_if_passed()
            elif event.kind is EventKind.DEPARTURE:
                place = self.place
                self._on = None if place is None or place.branch is None else self._edge(place.node, place.branch)
                self._traced = self._on

    def _count_if_passed(self) -> None:
        """Having driven the whole edge a point should lie beside, and not left it, try another."""
        traced, self._traced = self._traced, None
        if isinstance(self._destination, OnEdge) and traced == self._destination.edge:
            self._count_a_try("no place of the edge is nearer to the point than an obstacle")

    def _close_blocked(self) -> None:
        if self.locator.blocked is not None:
            self.closed.add(self.locator.blocked)

    def _decide(self, sense: Sense) -> GvgGoal | None:
        if self.progress is not Progress.UNDER_WAY or self._destination is None:
            return None
        place = self.place
        if self._straight is not None:
            return self._watch_straight(sense)
        if place is not None and not self._waiting:
            return self._back(place, sense) or self._watch(place, sense)
        if not self._waiting:
            return None
        if place is None:
            return self._search.next_goal(self._arrival)
        return self._from_here(place, sense)

    def _from_here(self, place: Place, sense: Sense) -> GvgGoal | None:
        """Decide where the robot stands, its place known."""
        destination = self._destination
        if isinstance(destination, OnEdge):
            near = self._seen_from(place, sense)
            if near is not None and (room := self._straight_to(near, place, sense)) is not None:
                return room
        if self._arrival is None:
            return self._access(place, sense)
        if not place.keys:  # before what blocks an edge: back
            return GvgGoal(GoalKind.TRACE, branch=0)
        if isinstance(destination, AtNode) and destination.node == place.node:
            self._end(Progress.REACHED)
            return None
        return self._first_edge(place)

    def _access(self, place: Place | None, sense: Sense) -> GvgGoal:
        """Return to the graph, and follow it the way that is shorter."""
        ways = None if place is None else self._both_ways(place, sense)
        self._turn_round = False
        if ways is None:
            return GvgGoal(GoalKind.ACCESS)
        onward = ways.heading_in_odom
        return GvgGoal(
            GoalKind.ACCESS, heading_in_odom=onward if ways.onward_m <= ways.back_m else wrap(onward + math.pi)
        )

    def _back(self, place: Place, sense: Sense) -> GvgGoal | None:
        """Turn round in the middle of an edge, where an errand that has just begun is clearly nearer that way."""
        ways = self._both_ways(place, sense) if self._turn_round else None
        if ways is None:
            return None
        self._turn_round = False
        facing_onward = abs(wrap(sense.base_in_odom.theta - ways.heading_in_odom)) < 0.5 * math.pi
        ahead_m, behind_m = (ways.onward_m, ways.back_m) if facing_onward else (ways.back_m, ways.onward_m)
        return self._access(place, sense) if behind_m + _TURNING_M < ahead_m else None

    def _both_ways(self, place: Place, sense: Sense) -> BothWays | None:
        """Weigh the two ways along the edge the robot is on or beside; None where it is not known there."""
        end, base = self._end_at(place), place.base_in_node(sense)
        if self._on is None or end is None or base is None or self._destination is None:
            return None
        turn = sense.base_in_odom.theta - base.theta
        return both_ways(self._state.graph, self._on, end, base, turn, self._destination, self._from_node_m)

    def _from_node_m(self, node: int) -> float:
        """Return what the rest of the way costs from a node, its own stop included."""
        if isinstance(self._destination, AtNode) and self._destination.node == node:
            return 0.0
        ways = self._ways(node, tuple(self._state.graph.nodes[node].branches))
        return PER_NODE_M + min((cost_m for cost_m, _ in ways), default=math.inf)

    def _first_edge(self, place: Place) -> GvgGoal | None:
        """Return the branch by which the shortest way to the destination leaves."""
        by = tuple(key for key in place.keys if key is not None)
        best = min(self._ways(place.node, by), default=None)
        if best is None:
            closed = f"; blocked: edges {', '.join(map(str, sorted(self.closed)))}" if self.closed else ""
            self._end(Progress.UNREACHABLE, f"no way leads there from node {place.node}{closed}")
            return None
        self.path_left_m, key = best
        return GvgGoal(GoalKind.TRACE, branch=place.keys.index(key))

    def _ways(self, node: int, by: tuple[int, ...]) -> Iterator[tuple[float, int]]:
        """Yield what the ways to the destination cost (m), with the branch each leaves by."""
        graph, destination = self._state.graph, self._destination
        targets: dict[int, list[float]] = {}
        if isinstance(destination, AtNode):
            targets[destination.node] = [0.0]
        elif destination is not None and destination.edge not in self.closed:
            for end in ends_of(graph, destination):
                targets.setdefault(end.node, []).append(end.along_m)
                if end.node == node and end.branch in by:
                    yield end.along_m, end.branch
        for there in outward(graph, node, by, self.closed):
            for rest_m in targets.get(there.node, ()):
                yield there.cost_m + rest_m, there.first

    def _watch(self, place: Place, sense: Sense) -> GvgGoal | None:
        """On the way along the destination's edge: leave it where the point is nearest and within reach."""
        destination = self._destination
        if not isinstance(destination, OnEdge) or self._on != destination.edge:
            return None
        end = self._end_at(place)
        base = place.base_in_node(sense)
        if end is None or base is None:
            return None
        seen = ends_of(self._state.graph, destination)[end]
        distance = math.dist(base[:2], seen.in_node)
        if distance < WATCHED_M and self._cycle % _CORRECT_EVERY == 0 and self.locator.correct(self._on, end, sense):
            corrected = self.place
            base = None if corrected is None else corrected.base_in_node(sense)
            if base is None:
                return None
            distance = math.dist(base[:2], seen.in_node)
        if not self._approach.is_time(distance, sense.room_m):
            return None
        self.locator.correct(self._on, end, sense)
        return self._set_out(seen, sense)

    def _seen_from(self, place: Place, sense: Sense) -> FromEnd | None:
        """Return the destination as seen from the node the place is about, None if its edge does not end there."""
        if not isinstance(self._destination, OnEdge) or place.base_in_node(sense) is None:
            return None
        ends = [end for end in ends_of(self._state.graph, self._destination) if end.node == place.node]
        base = place.base_in_node(sense)
        return min(ends, key=lambda end: math.dist(base[:2], end.in_node), default=None) if base else None

    def _straight_to(self, seen: FromEnd, place: Place, sense: Sense) -> GvgGoal | None:
        """Return a straight drive to a point that is nearer than any obstacle from where the robot stands."""
        base = place.base_in_node(sense)
        if base is None or math.dist(base[:2], seen.in_node) > min(sense.room_m, WATCHED_M):
            return None
        return self._set_out(seen, sense)

    def _set_out(self, seen: FromEnd, sense: Sense) -> GvgGoal | None:
        """Leave the graph for a point; from here on odometry leads."""
        self.locator.leave(sense)
        place = self.place
        if place is None:
            return None
        self._on = self._destination.edge if isinstance(self._destination, OnEdge) else None
        odom_in_node = place.frame_in_node.pose
        self._straight = odom_in_node.inverse().apply(*seen.in_node)
        self._arrival, self._waiting = None, False
        self._again, self._began = True, self._cycle
        return GvgGoal(GoalKind.STRAIGHT, x_in_odom=self._straight[0], y_in_odom=self._straight[1])

    def _watch_straight(self, sense: Sense) -> GvgGoal | None:
        """See whether the straight drive has ended, and where."""
        if self._straight is None or not sense.idle or self._cycle - self._began < 5:
            return None
        distance = math.dist(sense.base_in_odom[:2], self._straight)
        is_there = reached(distance, self._state.config.goal_tolerance_m)
        if not is_there and self._again:  # the body rolls on from the speed of tracing
            self._again, self._began = False, self._cycle
            return GvgGoal(GoalKind.STRAIGHT, x_in_odom=self._straight[0], y_in_odom=self._straight[1])
        self._straight, self._waiting = None, True
        if is_there:
            self._end(Progress.REACHED)
            return None
        self._count_a_try("something stands between the edge and the point")
        return self._access(self.place, sense) if self.progress is Progress.UNDER_WAY else None

    def _count_a_try(self, why: str) -> None:
        if self.progress is not Progress.UNDER_WAY:
            return
        self._tries += 1
        if self._tries >= _TRIES:
            self._end(Progress.UNREACHABLE, why)
        elif isinstance(self._destination, OnEdge):
            if self._others is None:
                self._others = [*otherwise(self._state.graph, self._state.maps, self._destination), self._destination]
            self._destination = self._others.pop(0) if self._others else self._destination

    def _end(self, progress: Progress, why: str = "") -> None:
        self.progress, self.why = progress, why
        self.path_left_m = 0.0 if progress is Progress.REACHED else math.nan

    def _end_at(self, place: Place) -> int | None:
        """Return which end of the edge the robot is on the place's node is."""
        if self._on is None:
            return None
        edge = self._state.graph.edges[self._on]
        if place.branch is not None:
            return edge.end_at(place.node, place.branch)
        return next((end for end in (0, 1) if edge.ends[end].node == place.node), None)

    def _edge(self, node: int, branch: int) -> int | None:
        return self._state.graph.nodes[node].branches[branch].edge
