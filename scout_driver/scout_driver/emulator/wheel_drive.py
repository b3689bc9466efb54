"""The emulated wheels: approach what VM or PR ask for at AC, hold on ST, roll out on LP."""

import math

from scout_driver.units import METRES_PER_UNIT, Wheels, within_wheel_speed

POWER_ON_MOVE_M_S = 0.3
"""SP before it is set (assumed)."""


class WheelDrive:
    """Two wheels with one acceleration limit."""

    def __init__(self, acceleration_m_s2: float, wheel_speed_max_m_s: float) -> None:
        """Begin at rest."""
        self.acceleration_m_s2, self._speed_max_m_s = acceleration_m_s2, wheel_speed_max_m_s
        self.move_speed = Wheels(POWER_ON_MOVE_M_S, POWER_ON_MOVE_M_S)
        self.speed = Wheels()
        """How fast the wheels turn now (m/s)."""
        self._target = Wheels()
        self._left_over: Wheels | None = None
        self.limp = False

    @property
    def wants_to_move(self) -> bool:
        """Whether a motion is being carried out that the watchdog would cut off."""
        return self._target != Wheels() or self._left_over is not None

    def velocity(self, wheels: Wheels) -> None:
        """VM: turn at these speeds until told otherwise."""
        self._target, self._left_over, self.limp = within_wheel_speed(wheels, self._speed_max_m_s), None, False

    def move(self, distance: Wheels) -> None:
        """PR: turn each wheel by a distance (m)."""
        self._target, self._left_over, self.limp = Wheels(), distance, False

    def stop(self, *, limp: bool = False) -> None:
        """ST: come to rest and hold; LP: come to rest with the motors off."""
        self._target, self._left_over, self.limp = Wheels(), None, limp

    def tick(self, duration_s: float, *, braked: bool) -> Wheels:
        """Let time pass, and return the speeds; ``braked``: nothing but slowing down is allowed."""
        target = Wheels() if braked or self.limp else self._wanted(duration_s)
        change = self.acceleration_m_s2 * duration_s
        right, left = self.speed
        self.speed = Wheels(
            min(max(target.right, right - change), right + change), min(max(target.left, left - change), left + change)
        )
        return self.speed

    def _wanted(self, duration_s: float) -> Wheels:
        """Return the speeds to approach: those of VM, or those that bring a PR to its end without overshoot."""
        if self._left_over is None:
            return self._target
        right, left = (d - w * duration_s for d, w in zip(self._left_over, self.speed, strict=True))
        if max(abs(right), abs(left)) < METRES_PER_UNIT:
            self._left_over = None
            return Wheels()
        self._left_over = Wheels(right, left)
        return Wheels(
            self._approach(right, self.move_speed.right),
            self._approach(left, self.move_speed.left),
        )

    def _approach(self, distance: float, fastest: float) -> float:
        return math.copysign(min(fastest, math.sqrt(2.0 * self.acceleration_m_s2 * abs(distance))), distance)
