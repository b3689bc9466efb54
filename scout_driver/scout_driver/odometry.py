"""The base's counters made into a pose that neither overflows nor jumps.

The base reports x, y in +-32767 tenths of an inch (83.2 m) and a heading modulo a turn. The driver
defines them anew (DP) long before they overflow; a reply may be lost on the way, so both readings,
old and new counters, are understood until one of them arrives.
"""

import math

from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.protocol.replies import State
from scout_driver.units import METRES_PER_UNIT, RADIANS_PER_UNIT, Wheels, velocity_from_wheels

SLACK_M = 0.05
SLACK_RAD = 0.1
"""What a step may exceed the fastest possible motion by (rounding, jitter of stamps)."""
CONFIRMATIONS = 3
"""So many states in a row that agree with each other but not with the past: the counters were set anew."""


class Odometry:
    """Integrates state frames into ``base_in_odom``, starting at zero."""

    def __init__(self, config: DriverConfig) -> None:
        """Start at the origin; the first state sets the reference."""
        self._config = config
        self._last: tuple[SE2, Velocity, float] | None = None
        self._suspects: list[tuple[SE2, float]] = []
        self._rebasing = False
        self.base_in_odom = SE2()
        self.odometer_m = 0.0
        """Distance driven since the driver started, forwards and backwards."""
        self.rejected = 0
        """States whose pose no motion explains (a damaged frame whose checksum held)."""
        self.jumps = 0
        """Times the base's counters were set anew behind the driver's back (power-cycled)."""
        self.rebases = 0
        """Times the driver set them anew."""

    def update(self, state: State, stamp_s: float) -> Velocity | None:
        """Take a state measured at ``stamp_s``; return the measured velocity, None if it is not believed."""
        raw, velocity = self._raw_pose(state), self._velocity(state)
        if self._last is None:
            self._last = raw, velocity, stamp_s
            return velocity
        last_raw, last_velocity, last_s = self._last
        elapsed = max(0.0, stamp_s - last_s)
        unwrapped = self._unwrapped(last_raw, raw)
        if self._plausible(last_raw, unwrapped, elapsed):
            self._advance(last_raw, unwrapped)
        elif self._rebasing and self._plausible(SE2(0.0, 0.0, last_raw.theta), raw, elapsed):
            self._bridge(last_velocity, velocity, elapsed, last_raw, raw)
            self._rebasing = False
            self.rebases += 1
        elif self._set_anew(raw, stamp_s):
            self._bridge(last_velocity, velocity, 0.0, raw, raw)
            self.jumps += 1
        else:
            self.rejected += 1
            return None
        self._suspects.clear()
        self._last = raw, velocity, stamp_s
        return velocity

    def needs_rebase(self) -> bool:
        """Tell whether the base's counters near their overflow."""
        limit = self._config.rebase_at_m
        return self._last is not None and max(abs(self._last[0].x), abs(self._last[0].y)) > limit

    def expect_rebase(self) -> None:
        """Note that the base has been told to call its position (0, 0)."""
        self._rebasing = True

    def zero(self) -> None:
        """Call the present pose the origin; the next state sets the reference."""
        self.base_in_odom = SE2()
        self._last = None
        self._suspects.clear()
        self._rebasing = False

    def _raw_pose(self, state: State) -> SE2:
        """Return the pose in the base's own frame."""
        turn = -1.0 if self._config.heading_clockwise else 1.0
        return SE2(state.x * METRES_PER_UNIT, state.y * METRES_PER_UNIT, wrap(turn * state.heading * RADIANS_PER_UNIT))

    def _unwrapped(self, before: SE2, after: SE2) -> SE2:
        """Return a raw pose with whole ranges of the counters added, so that it lies nearest the one before."""
        span = self._config.counter_span * METRES_PER_UNIT
        x = after.x + span * round((before.x - after.x) / span)
        y = after.y + span * round((before.y - after.y) / span)
        return SE2(x, y, after.theta)

    def _velocity(self, state: State) -> Velocity:
        """Return the measured velocity of the body, calibrated."""
        right, left = state.right * METRES_PER_UNIT, state.left * METRES_PER_UNIT
        wheels = Wheels(left, right) if self._config.swap_wheels else Wheels(right, left)
        forward, turn = velocity_from_wheels(wheels, self._config.wheel_base_m)
        return Velocity(forward * self._config.distance_scale, turn * self._config.rotation_scale)

    def _plausible(self, before: SE2, after: SE2, elapsed_s: float) -> bool:
        """Tell whether the base can have gone from one raw pose to the other."""
        reach = self._config.wheel_speed_max_m_s * elapsed_s
        moved = math.hypot(after.x - before.x, after.y - before.y)
        turned = abs(wrap(after.theta - before.theta))
        return moved <= 1.2 * reach + SLACK_M and turned <= 2.4 * reach / self._config.wheel_base_m + SLACK_RAD

    def _advance(self, before: SE2, after: SE2) -> None:
        """Add one raw step, in the body's frame, scaled by the calibration."""
        step = before.to(after)
        scale = self._config.distance_scale
        turned = wrap(after.theta - before.theta) * self._config.rotation_scale
        self.base_in_odom = self.base_in_odom @ SE2(step.x * scale, step.y * scale, turned)
        self.odometer_m += math.hypot(step.x, step.y) * scale

    def _bridge(self, before: Velocity, after: Velocity, elapsed_s: float, last_raw: SE2, raw: SE2) -> None:
        """Step over new counters: distance from the mean measured speed, rotation from the heading."""
        distance = 0.5 * (before.forward + after.forward) * elapsed_s
        turned = wrap(raw.theta - last_raw.theta) * self._config.rotation_scale
        half = SE2(0.0, 0.0, 0.5 * turned)
        self.base_in_odom = self.base_in_odom @ half @ SE2(distance, 0.0, 0.0) @ half
        self.odometer_m += abs(distance)

    def _set_anew(self, raw: SE2, stamp_s: float) -> bool:
        """Tell whether enough disbelieved states agree with each other to be the new counters."""
        agrees = not self._suspects or self._plausible(self._suspects[-1][0], raw, stamp_s - self._suspects[-1][1])
        if not agrees:
            self._suspects.clear()
        self._suspects.append((raw, stamp_s))
        return len(self._suspects) >= CONFIRMATIONS
