"""What a step is given, and what it answers: a command, and what to do next."""

from dataclasses import dataclass
from typing import NamedTuple

from hslam_gvg.driving.doing import Doing
from hslam_gvg.driving.handled import Handled
from hslam_gvg.driving.surroundings import Surroundings
from hslam_gvg.driving.traversal import Traversal
from hslam_gvg.follow_config import FollowConfig
from hslam_types.sensing import Velocity


@dataclass(frozen=True, slots=True)
class Now:
    """One step: when it is, what is round the robot, and which edge is under way."""

    stamp_ns: int
    around: Surroundings
    traversal: Traversal
    handled: Handled
    config: FollowConfig

    def since_s(self, stamp_ns: int) -> float:
        """Return the time (s) that has passed since a stamp."""
        return (self.stamp_ns - stamp_ns) * 1e-9


class Step(NamedTuple):
    """The answer of a step."""

    command: Velocity
    then: Doing
