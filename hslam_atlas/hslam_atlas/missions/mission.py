"""The protocol of missions: what happened goes in, a goal for the GVG level comes out."""

from dataclasses import dataclass
from typing import Protocol

from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import GvgEvent, GvgGoal


@dataclass(frozen=True, slots=True, eq=False)
class Happened:
    """What one cycle brought."""

    events: tuple[GvgEvent, ...] = ()
    edge_maps: tuple[EdgeMap, ...] = ()
    links: tuple[FrameLink, ...] = ()


@dataclass(frozen=True, slots=True)
class Decision:
    """What a mission makes of a cycle."""

    goal: GvgGoal | None = None
    """What the GVG level shall do next, if anything new."""
    finished: bool = False
    """Whether the mission has ended, whichever way."""


class Mission(Protocol):
    """One purpose, from its beginning to its end."""

    def step(self, happened: Happened) -> Decision:
        """Take one cycle."""

    def refused(self) -> None:
        """Be told that the GVG level did not take the goal."""
