"""Explore: drive until no branch that can be reached is unexplored."""

from hslam_atlas.explore import next_branch
from hslam_atlas.mapper import Mapper
from hslam_atlas.missions.mission import Decision, Happened
from hslam_atlas.questions import Questions
from hslam_atlas.second_looks import SecondLooks
from hslam_atlas.state import AtlasState
from hslam_types.gvg_events import EventKind, GoalKind, GvgGoal


class Explore:
    """Chooses a branch at every node; the mapper has entered what happened before it is asked."""

    def __init__(self, state: AtlasState, questions: Questions, mapper: Mapper) -> None:
        """Begin at once, or, with a traversal under way, at its end."""
        self._state, self._questions, self._mapper = state, questions, mapper
        self._waiting = mapper.underway is None
        """Whether the GVG level has nothing to do: at the start and after each arrival."""
        self._finished = False
        self._second_looks = SecondLooks(state)
        self._arrivals = 0

    @property
    def doing(self) -> str:
        """See `Mission`."""
        return "exploring"

    def step(self, happened: Happened) -> Decision:
        """Decide where to next if the GVG level waits for it; the end is told by STOP."""
        for event in happened.events:
            if event.kind is EventKind.DEPARTURE:
                self._waiting = False
            else:
                self._finished = False
                self._waiting |= event.kind in (EventKind.ARRIVAL, EventKind.LOST)
        goal: GvgGoal | None = None
        if self._waiting:
            goal = self._decide()
            self._finished = goal.kind is GoalKind.STOP
            self._waiting = False
        return Decision(goal, self._finished)

    def refused(self) -> None:
        """Decide anew: the robot is not where it was thought to be, and the mapper has been told."""
        self._waiting = True

    def _decide(self) -> GvgGoal:
        """Choose the branch to trace from the node the robot is at, or stop when nothing left can be reached."""
        here = self._mapper.here
        if here is None:
            return GvgGoal(GoalKind.ACCESS)
        self._arrivals += 1
        # Parts are compared edge by edge: at ever longer intervals, and before anything is given up.
        if self._arrivals & (self._arrivals - 1) == 0 and self._mapper.join_parts():
            return self._decide()
        key = next_branch(self._state, self._questions, here)
        if key is None and self._mapper.join_parts():
            return self._decide()
        if key is None:
            key = self._second_looks.next_branch(here)
        if key is None:
            return GvgGoal(GoalKind.STOP)
        return GvgGoal(GoalKind.TRACE, branch=here.keys.index(key))
