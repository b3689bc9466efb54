"""Localise: drive along the graph until one place of the atlas alone explains what was seen."""

from hslam_atlas.localisation.locator import Locator
from hslam_atlas.localisation.place import Place
from hslam_atlas.missions.mission import Decision, Happened
from hslam_atlas.retrace import similar_length
from hslam_atlas.state import AtlasState
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal


class Localise:
    """Reads the atlas and changes nothing in it; while it does not know where the robot is, it says so."""

    def __init__(
        self, state: AtlasState, locator: Locator | None = None, *, at: GvgEvent | None = None, waiting: bool = True
    ) -> None:
        """Begin lost, unless a locator knows better.

        ``at``: the arrival at the node the robot stands at; ``waiting``: whether the GVG level has nothing to do.
        """
        self._state = state
        self.locator = locator or Locator(state)
        self._waiting = waiting
        self.drives = 0
        """Arrivals until now."""
        self._last = at
        """The arrival at the node the robot stands at."""

    @property
    def doing(self) -> str:
        """See `Mission`."""
        return "localising"

    @property
    def given_up(self) -> bool:
        """Whether so many drives have shown no place that the robot may be where the atlas knows nothing."""
        return self.place is None and self.drives >= self._state.config.localise_drives

    @property
    def place(self) -> Place | None:
        """Where the robot is, None while that is in doubt."""
        return self.locator.certain

    def step(self, happened: Happened) -> Decision:
        """Weigh what happened; ask for another drive until the place is known."""
        self.locator.hear(happened)
        for event in happened.events:
            self._waiting |= event.kind in (EventKind.ARRIVAL, EventKind.LOST)
            self._last = event if event.kind is EventKind.ARRIVAL else None
            self.drives += event.kind is EventKind.ARRIVAL
        if self._last is not None and (self.place is not None or self.given_up):
            self._waiting = False
            return Decision(None, finished=True)
        if not self._waiting:
            return Decision()
        self._waiting = False
        return Decision(self.next_goal(self._last))

    def refused(self) -> None:
        """Reach the graph anew."""
        self._last, self._waiting = None, True

    def next_goal(self, arrival: GvgEvent | None) -> GvgGoal:
        """Return the drive that tells most: reach the graph, or trace a branch of the node arrived at."""
        if arrival is None or arrival.node is None or not arrival.node.degree:
            return GvgGoal(GoalKind.ACCESS)
        ways = [i for i in range(arrival.node.degree) if i != arrival.branch] or [arrival.branch]
        return GvgGoal(GoalKind.TRACE, branch=min(ways, key=lambda i: (*self._cost(i), (i - arrival.branch) % 100)))

    def _cost(self, index: int) -> tuple[int, int, float]:
        """Rank a branch in view: one that leads on, that tells the two likeliest places apart, the shortest."""
        lengths = [self._length_m(place, index) for place in self.locator.places[:2]]
        if not lengths:
            return 0, 0, 0.0
        first, second = lengths[0], lengths[-1]
        known = 1 if first is None else 0
        telling = 0
        if len(lengths) > 1 and first is not None and second is not None:
            telling = int(similar_length(first, second, self._state.config))
        return known, telling, first or 0.0

    def _length_m(self, place: Place, index: int) -> float | None:
        """Return the length of the edge a branch in view would be, None where there is none."""
        key = place.keys[index] if index < len(place.keys) else None
        edge = None if key is None else self._state.graph.nodes[place.node].branches[key].edge
        return None if edge is None else self._state.graph.edges[edge].path_length_m
