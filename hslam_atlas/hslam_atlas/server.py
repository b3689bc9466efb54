"""The atlas as one object: events, edge-maps and links in, the next goal out."""

from dataclasses import dataclass

from hslam_atlas.config import AtlasConfig
from hslam_atlas.explore import next_branch, unexplored
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.map_store import MapsInMemory
from hslam_atlas.mapper import Mapper
from hslam_atlas.questions import Questions
from hslam_atlas.state import AtlasState
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal


@dataclass(frozen=True, slots=True)
class AtlasOutput:
    """What one step brought."""

    goal: GvgGoal | None = None
    """What the GVG level shall do next, if anything new."""
    finished: bool = False
    """Whether no edge is left unexplored."""
    changed: bool = False
    """Whether graph or maps are not what they were."""
    closures: int = 0
    """Loops closed so far."""
    hypotheses: int = 0
    """Open questions of identity."""
    unexplored: int = 0
    """Branches left."""


class AtlasServer:
    """Builds the atlas from events and, on the mission "explore", decides what to drive."""

    def __init__(self, config: AtlasConfig | None = None) -> None:
        """Start with an empty atlas."""
        config = config or AtlasConfig()
        self.state = AtlasState(config, AtlasGraph(), MapsInMemory(), LookAlikes(config.repetition))
        self.questions = Questions()
        self.mapper = Mapper(self.state, self.questions)
        self._started = False
        self._finished = False
        self._unexplored = 0

    def step(
        self,
        stamp_ns: int,
        events: tuple[GvgEvent, ...],
        edge_maps: tuple[EdgeMap, ...],
        links: tuple[FrameLink, ...],
    ) -> AtlasOutput:
        """Take one cycle: enter what happened, then decide if the robot waits for a goal."""
        del stamp_ns  # everything is ordered by its own stamps already
        goal: GvgGoal | None = None
        if not self._started:
            self._started = True
            goal = GvgGoal(GoalKind.ACCESS)
        for event in events:
            goal = self._handle(event, edge_maps, links) or goal
        if self.state.config.mission != "explore":
            goal = None
        return AtlasOutput(
            goal, self._finished, bool(events), self.state.closures, len(self.questions.open), self._unexplored
        )

    def _handle(
        self, event: GvgEvent, edge_maps: tuple[EdgeMap, ...], links: tuple[FrameLink, ...]
    ) -> GvgGoal | None:
        """Enter one event; arrivals and losses ask for a goal."""
        if event.kind is EventKind.DEPARTURE:
            self.mapper.depart(event, next((link for link in links if link.departure == event.sequence), None))
        elif event.kind is EventKind.ARRIVAL:
            self.mapper.arrive(event, next((m for m in edge_maps if m.arrival == event.sequence), None))
            return self._decide()
        elif event.kind is EventKind.LOST:
            self.mapper.lose()
            return GvgGoal(GoalKind.ACCESS)
        return None

    def _decide(self) -> GvgGoal:
        """Choose the branch to trace from the node the robot is at, or stop when all is explored."""
        here = self.mapper.here
        assert here is not None
        self._unexplored = unexplored(self.state.graph)
        key = next_branch(self.state, self.questions, here)
        self._finished = key is None
        if key is None:
            return GvgGoal(GoalKind.STOP)
        return GvgGoal(GoalKind.TRACE, branch=here.keys.index(key))
