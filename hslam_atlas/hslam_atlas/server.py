"""The atlas as one object: events, edge-maps and links in, the next goal out."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from hslam_atlas.config import AtlasConfig
from hslam_atlas.dispatch import Dispatch
from hslam_atlas.errors import StoreError
from hslam_atlas.explore import unexplored
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.mapper import Mapper
from hslam_atlas.missions.mission import Happened, Sense
from hslam_atlas.numbering import Numbering
from hslam_atlas.questions import Questions
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent, GvgGoal


@dataclass(frozen=True, slots=True)
class AtlasOutput:
    """What one step brought."""

    goal: GvgGoal | None = None
    """What the GVG level shall do next, if anything new."""
    finished: bool = False
    """Whether the mission has ended; exploring: what is still unexplored, if anything, is out of reach."""
    changed: bool = False
    """Whether graph or maps are not what they were."""


class AtlasServer:
    """Builds the atlas from events; a mission, where there is one, decides what to drive."""

    def __init__(self, config: AtlasConfig | None = None, store: AtlasStore | None = None) -> None:
        """Take up the atlas in the store, or an empty one in memory; where the robot is has to show."""
        config = config or AtlasConfig()
        self.store = store or AtlasStore()
        graph, doubts = self.store.load()
        counts = self.store.counts()
        alike = LookAlikes.from_counts(config.repetition, counts)
        self.state = AtlasState(config, graph, self.store, alike, closures=counts.get("closures", 0))
        self.questions = Questions(self.state.look_alikes)
        self.questions.open = doubts
        self.mapper = Mapper(self.state, self.questions)
        self._numbering = Numbering(graph)
        self.dispatch = Dispatch(self.state, self.questions, self.mapper, self._numbering)
        self.unexplored = unexplored(graph)
        """How many branches are left to explore, counted when the atlas changes: that takes a look at every node."""
        self.unsaved: str | None = None
        """Why the newest of the atlas is not in its file yet, None where it is."""
        self.dispatch.begin(config.mission)

    @property
    def exploring(self) -> bool:
        """Whether the mission is to explore."""
        return self.dispatch.exploring

    def explore(self) -> None:
        """Take up the mission to explore, from the next step on; no news where that is the mission already."""
        self.dispatch.explore()

    def stop(self) -> None:
        """Give up the mission; the traversal under way is driven to its end."""
        self.dispatch.stop()

    def refused(self) -> None:
        """Be told that the GVG level did not take the goal: the robot is not where it was thought to be."""
        self.dispatch.refused()

    def lose(self) -> None:
        """Be told that what is under way will not be announced to its end: where the robot is has to show."""
        self.dispatch.lose()

    def step(
        self,
        events: tuple[GvgEvent, ...],
        edge_maps: tuple[EdgeMap, ...],
        links: tuple[FrameLink, ...],
        sense: Sense | None = None,
    ) -> AtlasOutput:
        """Take one cycle: enter what happened, unless the atlas is only used; decide if the robot waits for a goal.

        ``sense`` is needed by missions that use the atlas.
        """
        changed, visits = False, self.mapper.visits
        if events:  # a session's first event tells how it is counted, though nothing is entered while the robot is lost
            self._numbering.event(events[0])
        if self.dispatch.locator is None:
            for event in events:
                changed |= self._enter(event, edge_maps, links)
        decision = self.dispatch.step(Happened(events, edge_maps, links, sense or Sense()))
        changed |= self.mapper.visits != visits
        if changed:
            self.unexplored = unexplored(self.state.graph)
            self.try_to_save()
        return AtlasOutput(decision.goal, decision.finished, changed)

    def save(self) -> None:
        """Write what is not in the file yet; raises StoreError, and the next save will write it."""
        counts = {"closures": self.state.closures} | self.state.look_alikes.counts
        try:
            self.store.save(self.state.graph, self.questions.open, counts)
            self.unsaved = None
        except StoreError as error:
            self.unsaved = str(error)
            raise

    def try_to_save(self) -> None:
        """Write what is not in the file yet; where that cannot be, `unsaved` says why, and the robot goes on."""
        with suppress(StoreError):
            self.save()

    def save_rest(self) -> None:
        """Write what could not be written until now, if there is such; raises StoreError if it still cannot be."""
        if self.unsaved is not None:
            self.save()

    def save_as(self, path: Path) -> None:
        """Write a copy of the atlas to another file; raises StoreError."""
        self.save()
        self.store.save_as(path)

    def identify(self, node: int) -> bool:
        """Be told, by someone who knows, that the robot is at a certain node; False if that contradicts the map."""
        taken = self.mapper.be_told(node)
        if taken:
            self.unexplored = unexplored(self.state.graph)
            self.try_to_save()
        return taken

    def _enter(self, event: GvgEvent, edge_maps: tuple[EdgeMap, ...], links: tuple[FrameLink, ...]) -> bool:
        """Enter one event; return whether the atlas has changed."""
        event = self._numbering.event(event)
        edge_maps = tuple(self._numbering.edge_map(m) for m in edge_maps)
        links = tuple(self._numbering.link(link) for link in links)
        begins = event.kind in (EventKind.ACCESS, EventKind.DEPARTURE)
        # What is under way when another traversal begins has ended without a word.
        broken_off = begins and self.mapper.underway is not None
        if broken_off:
            self.mapper.lose()
        if event.kind is EventKind.DEPARTURE:
            self.mapper.depart(event, next((link for link in links if link.departure == event.sequence), None))
            return broken_off
        if event.kind is EventKind.ARRIVAL:
            self.mapper.arrive(event, next((m for m in edge_maps if m.arrival == event.sequence), None))
        elif event.kind is EventKind.LOST:
            self.mapper.lose()
        else:
            return broken_off
        return True
