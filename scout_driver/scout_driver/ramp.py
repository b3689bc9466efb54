"""Acceleration limits: speeding up is rationed; slowing down is asked for at once and left to the wheels."""

from hslam_types.sensing import Velocity


class Ramp:
    """Approaches each new target within the two acceleration limits."""

    def __init__(self, acceleration_m_s2: float, turn_acceleration_rad_s2: float) -> None:
        """Begin at rest."""
        self._limits = Velocity(acceleration_m_s2, turn_acceleration_rad_s2)
        self.velocity = Velocity()
        """What was asked of the base last."""

    def toward(self, target: Velocity, elapsed_s: float) -> Velocity:
        """Return, and remember, the velocity ``elapsed_s`` later on the way to ``target``."""
        self.velocity = Velocity(
            _approach(self.velocity.forward, target.forward, self._limits.forward * elapsed_s),
            _approach(self.velocity.turn, target.turn, self._limits.turn * elapsed_s),
        )
        return self.velocity

    def halt(self) -> None:
        """Begin at rest again."""
        self.velocity = Velocity()


def _approach(value: float, target: float, change: float) -> float:
    """Return ``target`` where it is slower; else the next value on the way, through rest if the sign changes."""
    slowest = value if value * target > 0.0 else 0.0
    return min(max(target, min(slowest, 0.0) - change), max(slowest, 0.0) + change)
