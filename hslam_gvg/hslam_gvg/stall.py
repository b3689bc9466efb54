"""Being held: the wheels are told to drive and do not turn.

A silent corner is found by the body alone.  What held it shows in the odometry of the same cycle, so the answer is
the same in lock-step, in a replay and on a base without bumpers; a bumper's message has no order with the cycle.
"""

from hslam_types.sensing import OdometrySample, Velocity

STALL_S = 0.5
"""Held for so long (s): longer than a command's way to the wheels and their acceleration take."""
LEAST_M_S = 0.03
"""Slower commands (m/s) say nothing: the encoders are too coarse."""
HELD = 0.2
"""Held is who covers less than this share of what was commanded."""


class StallWatch:
    """Compares what was commanded with what the wheels did, cycle by cycle."""

    def __init__(self) -> None:
        """Begin at rest."""
        self._told = 0.0
        self._before: OdometrySample | None = None
        self._held_s = 0.0

    @property
    def direction(self) -> float:
        """The sign of the motion last commanded: 1 forwards, -1 backwards."""
        return -1.0 if self._told < 0.0 else 1.0

    def reset(self) -> None:
        """Forget what was commanded before: a new goal does not answer for how the last one ended."""
        self._told = self._held_s = 0.0

    def sees(self, odom: OdometrySample) -> bool:
        """Take the odometry that answers the last command; True once the base has been held for `STALL_S`."""
        before, self._before = self._before, odom
        if before is None:
            return False
        elapsed_s = (odom.stamp_ns - before.stamp_ns) * 1e-9
        ahead, aside = before.base_in_odom.inverse().apply(odom.base_in_odom.x, odom.base_in_odom.y)
        told_m = abs(self._told) * elapsed_s
        held = abs(self._told) >= LEAST_M_S and abs(ahead) + abs(aside) < HELD * told_m
        self._held_s = self._held_s + elapsed_s if held else 0.0
        if self._held_s < STALL_S:
            return False
        self._held_s = 0.0
        return True

    def tell(self, command: Velocity) -> None:
        """Take the command that goes out; a change of direction begins anew."""
        if command.forward * self._told < 0.0:
            self._held_s = 0.0
        self._told = command.forward
