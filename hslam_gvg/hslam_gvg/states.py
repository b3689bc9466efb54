"""The states of the GVG level, what a step answers and what cannot be done."""

from dataclasses import dataclass
from enum import Enum

from hslam_types.errors import HslamError
from hslam_types.gvg_events import GvgEvent
from hslam_types.sensing import Velocity


class GvgError(HslamError):
    """A goal cannot be taken as things stand."""


class GvgState(Enum):
    """What the robot is doing."""

    IDLE = "idle"
    LISTENING = "listening"
    ACCESSING = "accessing"
    TURNING = "turning"
    TRACING = "tracing"
    HOMING = "homing"
    PROBING = "probing"
    SETTLING = "settling"
    RESUMING = "resuming"
    BACKING = "backing"
    RECOILING = "recoiling"
    STRAIGHT = "straight"
    WATCHING = "watching"


ON_EDGE = frozenset(
    {
        GvgState.TRACING,
        GvgState.HOMING,
        GvgState.PROBING,
        GvgState.SETTLING,
        GvgState.RESUMING,
        GvgState.BACKING,
        GvgState.RECOILING,
    }
)
"""The states in which a traversal may be under way; in any other one none is."""


@dataclass(frozen=True, slots=True)
class GvgOutput:
    """The answer to one step."""

    command: Velocity
    events: tuple[GvgEvent, ...]
    state: GvgState
    dropped: str = ""
    """Why the goal whose time had come was not begun; what was under way goes on."""
