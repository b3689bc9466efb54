"""The driver: the table of what steps what, and the body kept off what it could meet."""

import math
from collections.abc import Callable
from typing import Any

from hslam_gvg.driving.doing import (
    KINDS,
    Accessing,
    Attending,
    BackingOff,
    Crossing,
    Doing,
    Following,
    GoingStraight,
    Homing,
    Idle,
    Returning,
    Turning,
    hindered,
)
from hslam_gvg.driving.follow import attend, follow
from hslam_gvg.driving.home import go_back, home
from hslam_gvg.driving.now import Now, Step
from hslam_gvg.driving.set_out import access, cross, go_straight, turn
from hslam_gvg.stall import StallWatch
from hslam_gvg.states import GvgState
from hslam_types.sensing import OdometrySample, Velocity

BLOCKED_STEPS, HELD_STEPS = 6, 10
"""Steps of backing off: from what was seen in time, and from what held the body."""


def stand(doing: Idle, _: Now) -> Step:
    """Stand."""
    return Step(Velocity(), doing)


def back_off(doing: BackingOff, _: Now) -> Step:
    """Drive away, and after some steps go on."""
    then = doing.then if doing.steps <= 1 else BackingOff(doing.then, doing.velocity_m_s, doing.steps - 1)
    return Step(Velocity(doing.velocity_m_s, 0.0), then)


STEPS: dict[type[Doing], Callable[[Any, Now], Step]] = {
    Idle: stand,
    Turning: turn,
    Accessing: access,
    Crossing: cross,
    GoingStraight: go_straight,
    Following: follow,
    Attending: attend,
    Homing: home,
    Returning: go_back,
    BackingOff: back_off,
}


class Driver:
    """Does one thing at a time."""

    def __init__(self) -> None:
        """Begin idle."""
        self.doing: Doing = Idle()
        self._stall = StallWatch()
        self._blocked_since_ns: int | None = None

    @property
    def kind(self) -> GvgState:
        """What is being done."""
        return KINDS[type(self.doing)]

    @property
    def attentive(self) -> bool:
        """Whether every scan is to be mapped, though the robot stands."""
        return isinstance(self.doing, Accessing) or (isinstance(self.doing, Homing) and self.doing.stood > 0)

    def begin(self, doing: Doing) -> None:
        """Do something else from now on."""
        self.doing = doing
        self._stall.reset()
        self._blocked_since_ns = None

    def step(self, odom: OdometrySample, now: Now) -> Velocity:
        """Return the command of one step."""
        if self._stall.sees(odom):
            ahead = 0.0 if self._stall.direction > 0.0 else math.pi
            now.around.touch(now.around.pose.theta + ahead)
            self._recoil(self._stall.direction, HELD_STEPS, now)
        wanted, self.doing = STEPS[type(self.doing)](self.doing, now)
        command, blocked = now.around.limited(wanted)
        if not blocked:
            self._blocked_since_ns = None
        elif self._blocked_since_ns is None:
            self._blocked_since_ns = now.stamp_ns
        elif now.since_s(self._blocked_since_ns) > now.config.blocked_s:
            self._blocked_since_ns = None
            self._recoil(math.copysign(1.0, wanted.forward), BLOCKED_STEPS, now)
        self._stall.tell(command)
        return command

    def _recoil(self, direction: float, steps: int, now: Now) -> None:
        """Back off from what stopped a motion forwards (1) or backwards (-1)."""
        doing = self.doing.then if isinstance(self.doing, BackingOff) else self.doing
        self.doing = BackingOff(hindered(doing), -direction * now.config.back_m_s, steps)
