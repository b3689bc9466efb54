"""What the robot can be doing: one frozen value for each, without behaviour; a step replaces one by the next.

`hslam_gvg.driving.driver` has the table of which function steps which.
"""

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

from hslam_gvg.states import GvgState
from hslam_types.gvg_events import NodeView
from hslam_types.se2 import Array
from hslam_voronoi.branch_graph import Hub


class Stand(NamedTuple):
    """The node the robot stands at, with the path of each of its branches (k x 3, from the node)."""

    view: NodeView
    paths: tuple[Array, ...]


@dataclass(frozen=True, slots=True)
class Idle:
    """Standing, at a node or anywhere."""

    at: Stand | None = None


@dataclass(frozen=True, slots=True)
class Turning:
    """On the spot to a branch of the node stood at, to depart by it."""

    at: Stand
    branch: int
    since_ns: int


@dataclass(frozen=True, slots=True)
class Accessing:
    """Looking for the GVG from anywhere."""

    since_ns: int
    turned: float
    """The odometer's angle when it began (rad)."""
    way: float | None = None
    """The direction to follow it in (rad, odom), None for that of the robot."""
    crossed: bool = False
    """Whether the robot has driven on in the open as far as it may."""


@dataclass(frozen=True, slots=True)
class Crossing:
    """Straight on through open space, to where there is a graph."""

    heading: float
    """Direction of the drive (rad, odom)."""
    until_m: float
    """The odometer's reading at which it is given up."""


@dataclass(frozen=True, slots=True)
class GoingStraight:
    """To a point nearer than any obstacle (m, odom)."""

    x: float
    y: float
    blocks: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    """Along an edge, on a path (k x 3: x, y, clearance; m, odom)."""

    path: Array
    hub: Hub | None = None
    """The node at its end, by the last look."""
    is_exit: bool = True
    """Whether that end is where the known ends."""
    is_doubtful: bool = False
    """Whether it is not known all round yet."""
    missed: bool = False
    """Whether no way of the last look goes on with the path."""
    end_looks: int = 0
    """Looks that found the path at its end."""
    anew: int = 0
    """How often another way was taken where the path had ended."""
    anew_m: float = 0.0
    """The length of the traversal when that was last so."""
    blocks: int = 0
    """How often the body was stopped."""
    attended: bool = False
    """Whether the robot has turned where the path ended."""


@dataclass(frozen=True, slots=True, eq=False)
class Attending:
    """Turning on the spot where a path has ended, to hear whether it goes on."""

    then: Following
    turned: float
    """The odometer's angle when it began (rad)."""


@dataclass(frozen=True, slots=True, eq=False)
class Homing:
    """On a node of the local graph, and looking at it once more before it is announced."""

    x: float
    y: float
    clearance_m: float
    is_end: bool
    """Whether it is a dead end, which need not be reached to the last."""
    since_ns: int
    onward: Array
    """The path to go on with (k x 3), should there be no node."""
    returned: bool = False
    """Whether it is the node departed from, come back to."""
    again: bool = False
    """Whether the last look at it has moved it already."""
    stood: int = 0
    """Steps stood there."""
    turned: float = 0.0
    """The odometer's angle when that began (rad)."""
    blocks: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Returning:
    """Back to the node departed from."""

    path: Array
    """The trail backwards as it was when the edge was given up, k x 3."""
    since_ns: int
    blocks: int = 0


@dataclass(frozen=True, slots=True)
class BackingOff:
    """Away from what stopped the body, then on with what was being done."""

    then: "Doing"
    velocity_m_s: float
    steps: int


Doing = Idle | Turning | Accessing | Crossing | GoingStraight | Following | Attending | Homing | Returning | BackingOff

KINDS: dict[type[Doing], GvgState] = {
    Idle: GvgState.IDLE,
    Turning: GvgState.TURNING,
    Accessing: GvgState.LISTENING,
    Crossing: GvgState.ACCESSING,
    GoingStraight: GvgState.STRAIGHT,
    Following: GvgState.TRACING,
    Attending: GvgState.TRACING,
    Homing: GvgState.HOMING,
    Returning: GvgState.BACKING,
    BackingOff: GvgState.RECOILING,
}
"""What each is called outside."""

GIVE_UP_AFTER = 4
"""Stopped so often on one edge, the robot takes the way for blocked."""


def hindered(doing: Doing) -> Doing:
    """Return what is being done once the body was stopped on its way; who does not drive is not hindered."""
    match doing:
        case Following(missed=True):
            # The path is of no graph any more: one stop is enough.
            return dataclasses.replace(doing, blocks=doing.blocks + GIVE_UP_AFTER)
        case Following() | Homing() | Returning() | GoingStraight():
            return dataclasses.replace(doing, blocks=doing.blocks + 1)
        case _:
            return doing
