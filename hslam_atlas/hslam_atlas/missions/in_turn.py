"""Two missions, the second begun in the cycle that ends the first."""

from collections.abc import Callable

from hslam_atlas.missions.mission import Decision, Happened, Mission


class InTurn:
    """The first, then what is made of its end: explore once the robot is found, return once all is explored."""

    def __init__(self, first: Mission, then: Callable[[], Mission | None]) -> None:
        """Begin with the first; ``then`` is called when it has finished, and may know of nothing more."""
        self._now = first
        self._then: Callable[[], Mission | None] | None = then

    @property
    def now(self) -> Mission:
        """The mission under way."""
        return self._now.now if isinstance(self._now, InTurn) else self._now

    @property
    def doing(self) -> str:
        """See `Mission`."""
        return self._now.doing

    def step(self, happened: Happened) -> Decision:
        """Take one cycle."""
        decision = self._now.step(happened)
        following = self._then() if decision.finished and self._then is not None else None
        if following is None:
            return decision
        self._now, self._then = following, None
        return self._now.step(Happened(sense=happened.sense))

    def refused(self) -> None:
        """Be told that the GVG level did not take the goal."""
        self._now.refused()
