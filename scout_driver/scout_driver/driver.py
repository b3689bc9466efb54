"""The driver without ROS: one exchange with the base a cycle, and everything that makes it safe.

What is sent is decided anew each cycle, in this order: set the base up, stop it, re-base its counters,
drive. A base that stands still is only asked for its state: no damage to so short a frame can make a
velocity of it.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from hslam_types.se2 import SE2
from hslam_types.sensing import SonarPing, Velocity
from scout_driver.board_clock import BoardClock
from scout_driver.clock import Clock, Dating
from scout_driver.config import DriverConfig
from scout_driver.errors import LineLostError, ProtocolError
from scout_driver.line import Answer, Line, LineCounts
from scout_driver.motion_guard import Hold, MotionGuard
from scout_driver.odometry import Odometry
from scout_driver.protocol.commands import Command, CommandKind, sonar_command, wheel_command
from scout_driver.protocol.replies import State
from scout_driver.ramp import Ramp
from scout_driver.sonar_schedule import SonarSchedule
from scout_driver.transport import Transport
from scout_driver.units import speed_units, wheels_from_velocity, within_wheel_speed

SETUP_AFTER_SILENCE_S = 2.0
"""After so long a silence the base may have been switched off: it is set up again."""
STOP_ATTEMPTS = 20
"""Exchanges spent on stopping the base before the line is let go; the watchdog is there for the rest."""


@dataclass(frozen=True, slots=True)
class Reading:
    """What one exchange taught."""

    stamp_s: float
    """When it was measured, on the driver's clock."""
    state: State
    base_in_odom: SE2
    velocity: Velocity
    pings: tuple[tuple[float, SonarPing], ...]
    """(Moment of firing on the driver's clock, ping) of the firings since the last reading, oldest first."""


class ScoutDriver:
    """Keeps one base in hand, over whatever happens to its line."""

    def __init__(
        self,
        config: DriverConfig,
        clock: Clock,
        open_transport: Callable[[], Transport],
        dating: Dating | None = None,
    ) -> None:
        """``open_transport`` opens the line anew each time it is lost; ``dating`` is by default a `BoardClock`."""
        self._config, self._clock, self._open = config, clock, open_transport
        self._dating = dating or BoardClock()
        self._line: Line | None = None
        self._counts = LineCounts()
        self._setup: deque[Command] = deque()
        self._answered_s = self._cycle_s = clock.now() - 1e9
        self._cycles_to_attempt = 0
        self._ramp = Ramp(config.acceleration_m_s2, config.turn_acceleration_rad_s2)
        self._standing = self._rebased_last = False
        self.guard = MotionGuard(config)
        self.odometry = Odometry(config)
        self.sonar = SonarSchedule(config)
        self.line_losses = 0
        """Times the line was lost."""
        self.line_error = ""
        """Why the line is or was down."""

    @property
    def connected(self) -> bool:
        """Whether the line is open (which says nothing about a base at its other end)."""
        return self._line is not None

    @property
    def counts(self) -> LineCounts:
        """What has happened on the line, over all times it was opened."""
        return self._counts

    def now(self) -> float:
        """Return the time on the driver's clock (s)."""
        return self._clock.now()

    def command(self, velocity: Velocity) -> None:
        """Ask for a velocity; it holds until the next one or the time-out."""
        self.guard.command(velocity, self._clock.now())

    def hold(self) -> Hold | None:
        """Return why the base is being held, None if commands are obeyed."""
        return self.guard.hold(self._clock.now())

    def enable(self) -> None:
        """Begin to obey commands; what was asked for before is forgotten."""
        self.guard.forget_command()
        self.guard.enabled = True

    def disable(self) -> bool:
        """Stop obeying and stop the base; tell whether the base is known to stand still."""
        self.guard.enabled = False
        for _ in range(STOP_ATTEMPTS):
            if self._standing or self._line is None:
                break
            self.cycle()
        return self._standing

    def set_limp(self, *, limp: bool) -> None:
        """Switch the motors off, so that a person can push the base, or have it hold its position again."""
        self.guard.limp = limp
        self.guard.forget_command()
        self._standing = False

    def cycle(self) -> Reading | None:
        """Carry out one exchange; None if it brought nothing to believe. Never raises on what the base does."""
        now_s = self._clock.now()
        line = self._line or self._connect()
        if line is None:
            return None
        if now_s - self._answered_s > SETUP_AFTER_SILENCE_S and not self._setup:
            self._begin_setup()
        command = self._next_command(now_s)
        try:
            answer = line.request(command)
            return self._take(command, answer) if answer is not None else None
        except LineLostError as error:
            self._lose_line(error)
        except ProtocolError:
            self._counts.unexpected += 1
        return None

    def close(self, *, stop: bool = True) -> None:
        """Stop the base, unless told that it needs none, and let the line go."""
        if stop:
            self.disable()
        if self._line is not None:
            self._line.close()
            self._line = None

    def _connect(self) -> Line | None:
        # Counted in cycles: without a line no clock of the base goes on.
        self._cycles_to_attempt -= 1
        if self._cycles_to_attempt > 0:
            return None
        self._cycles_to_attempt = round(self._config.reconnect_s / self._config.cycle_s)
        try:
            self._line = Line(self._open(), self._config, self._clock, self._counts)
        except LineLostError as error:
            self.line_error = str(error)
            return None
        self._begin_setup()
        return self._line

    def _lose_line(self, error: LineLostError) -> None:
        self.line_losses += 1
        self.line_error = str(error)
        if self._line is not None:
            self._line.close()
        self._line = None
        self._cycles_to_attempt = round(self._config.reconnect_s / self._config.cycle_s)
        self._standing = False

    def _begin_setup(self) -> None:
        """Set the base up from scratch, beginning with a stop; what was asked for before is forgotten."""
        config = self._config
        units = speed_units(config.wheel_acceleration_m_s2)
        self._standing = False
        self.guard.forget_command()
        self._setup = deque(
            (
                Command(CommandKind.STOP),
                Command(CommandKind.CONFIGURE_WATCHDOG, (config.watchdog_s,)),
                wheel_command(CommandKind.ACCELERATION, units, units),
                sonar_command(config.sonar_rate, config.firing_order()),
            )
        )

    def _next_command(self, now_s: float) -> Command:
        elapsed_s = min(max(0.0, now_s - self._cycle_s), 2.0 * self._config.cycle_s)
        self._cycle_s = now_s
        target = self.guard.allowed(now_s)
        if self._setup or self.guard.hold(now_s) is not None:
            self._ramp.halt()
        if self._setup:
            return self._setup[0]
        if self.guard.limp:
            return Command(CommandKind.STATE if self._standing else CommandKind.LIMP)
        right, left = self._wheel_units(self._ramp.toward(target, elapsed_s))
        if right == left == 0 and not self._standing:
            return Command(CommandKind.STOP)
        if self.odometry.needs_rebase() and not self._rebased_last:
            self.odometry.expect_rebase()
            self._rebased_last = True
            return Command(CommandKind.DEFINE_POSITION, (0, 0))
        self._rebased_last = False
        if right == left == 0:
            return Command(CommandKind.STATE)
        self._standing = False
        return wheel_command(CommandKind.VELOCITY, right, left)

    def _wheel_units(self, velocity: Velocity) -> tuple[int, int]:
        """Return what to send for the first and the second axis."""
        wheels = wheels_from_velocity(velocity, self._config.wheel_base_m)
        wheels = within_wheel_speed(wheels, self._config.wheel_speed_max_m_s)
        first, second = (wheels.left, wheels.right) if self._config.swap_wheels else (wheels.right, wheels.left)
        return speed_units(first), speed_units(second)

    def _take(self, command: Command, answer: Answer) -> Reading | None:
        state = answer.state
        stamp_s = self._dating.stamp(state.board_ms, answer.received_s, answer.line_s)
        jumps = self.odometry.jumps
        velocity = self.odometry.update(state, stamp_s)
        if velocity is None:
            return None
        now_s = self._clock.now()
        self._answered_s = now_s
        self.guard.answered(state, now_s)
        self._note_standing(command, state)
        pings: list[tuple[float, SonarPing]] = []
        if self._setup:  # then it was its first command that has been answered
            self._setup.popleft()
            if command.kind == CommandKind.CONFIGURE_SONAR:
                self.sonar.restart(stamp_s)
        if not self._setup:
            pings = self.sonar.pings(state, stamp_s)
        if self.odometry.jumps > jumps:
            self._begin_setup()  # switched off and on: watchdog, acceleration and sonars have to be set anew
        return Reading(stamp_s, state, self.odometry.base_in_odom, velocity, tuple(pings))

    def _note_standing(self, command: Command, state: State) -> None:
        """Keep track of whether the base is known to obey a stop (or, limp, to have its motors off)."""
        if command.kind == CommandKind.LIMP:
            self._standing = True
        elif not self.guard.limp:
            still = state.right == 0 and state.left == 0
            self._standing = still and (self._standing or command.kind == CommandKind.STOP)
