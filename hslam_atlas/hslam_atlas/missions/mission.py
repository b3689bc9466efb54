"""The protocol of missions: what happened goes in, a goal for the GVG level comes out."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import GvgEvent, GvgGoal
from hslam_types.se2 import SE2

_ORIGIN = SE2()


@dataclass(frozen=True, slots=True, eq=False)
class Sense:
    """What the other levels know of the robot at the end of a cycle, beyond their events and maps."""

    base_in_odom: SE2 = _ORIGIN
    traversal: int = -1
    """The traversal whose frame the robot is tracked in, -1 without one."""
    base_in_frame: SE2 | None = None
    """Pose of base_link in that frame: the departure's, from the arrival on the edge-map's."""
    so_far: Callable[[GvgEvent | None], EdgeMap | None] = lambda _: None
    """The map of the traversal under way, as if it ended where the robot is, or at an arrival; None without one."""
    room_m: float = math.inf
    """The clearance where the robot is."""
    idle: bool = False
    """Whether the GVG level does nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Happened:
    """What one cycle brought."""

    events: tuple[GvgEvent, ...] = ()
    edge_maps: tuple[EdgeMap, ...] = ()
    links: tuple[FrameLink, ...] = ()
    sense: Sense = field(default_factory=Sense)


@dataclass(frozen=True, slots=True)
class Decision:
    """What a mission makes of a cycle."""

    goal: GvgGoal | None = None
    """What the GVG level shall do next, if anything new."""
    finished: bool = False
    """Whether the mission has ended, whichever way."""


class Mission(Protocol):
    """One purpose, from its beginning to its end."""

    @property
    def doing(self) -> str:
        """What it is about, in one word."""

    def step(self, happened: Happened) -> Decision:
        """Take one cycle."""

    def refused(self) -> None:
        """Be told that the GVG level did not take the goal."""
