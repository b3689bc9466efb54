"""The Scout as it looks from its serial port: commands in, state out, and a watchdog in between.

Time goes in ticks; what a state frame reports was true at the board time it reports.
"""

import math

from hslam_types.se2 import SE2
from scout_driver.emulator.config import EmulatorConfig
from scout_driver.emulator.floor import Floor
from scout_driver.emulator.sonar_board import SonarBoard
from scout_driver.emulator.wheel_drive import WheelDrive
from scout_driver.protocol.commands import Command, CommandKind
from scout_driver.protocol.framing import Frame
from scout_driver.protocol.numbers import SIGNED_MAX
from scout_driver.protocol.replies import (
    STATE_REPLIES,
    MotorStatus,
    State,
    motor_byte,
    readings_to_frame,
    state_to_frame,
)
from scout_driver.units import (
    METRES_PER_UNIT,
    MOTOR_DIVIDER,
    PROCESSOR_DIVIDER,
    RADIANS_PER_UNIT,
    Wheels,
    raw_volts,
    speed_units,
)

FULL_TURN = 3600
COUNTER_MS = 1 << 32
BATTERY_HIGH = 2


class EmulatedBase:
    """One base on one floor."""

    def __init__(self, floor: Floor, config: EmulatorConfig) -> None:
        """Switch the base on, standing still."""
        self._floor, self._config = floor, config
        self._ticks, self._tick_s = 0, config.tick_ms * 1e-3
        self._drive = WheelDrive(config.acceleration_m_s2, config.wheel_speed_max_m_s)
        self.sonar = SonarBoard(config.sonar_no_echo)
        self._watchdog_s, self._fed_s = 0.0, 0.0
        self._bumped_s = -math.inf
        self._waiting_until_s: float | None = None
        self.emergency_stop = False
        """The red button; held down until set back."""
        self.aborts = 0
        """Motions cut off by the watchdog."""

    @property
    def now_s(self) -> float:
        """Board time."""
        return self._ticks * self._tick_s

    @property
    def board_ms(self) -> int:
        """Board time as the state frame tells it."""
        return self._ticks * self._config.tick_ms % COUNTER_MS

    @property
    def moving(self) -> bool:
        """Whether a wheel turns."""
        return self._drive.speed != Wheels()

    def advance(self, to_s: float) -> None:
        """Let time pass up to the last tick not after ``to_s``."""
        while (self._ticks + 1) * self._tick_s <= to_s + 1e-9:
            self._tick()

    def handle(self, command: Command) -> Frame | None:
        """Carry out a command and return its reply; None if that has to wait (WS), see `waited`."""
        self.carry_out(command)
        return self.waited() if command.kind == CommandKind.WAIT_STOPPED else self.reply(command.kind)

    def carry_out(self, command: Command) -> None:
        """Do what a command says."""
        kind = command.kind
        if kind != CommandKind.STATE or self._config.state_feeds_watchdog:
            self._fed_s = self.now_s
        if kind == CommandKind.WAIT_STOPPED:
            self._waiting_until_s = self.now_s + command.values[3]
        elif kind in MOTION:
            self._move(kind, command.values)
        elif kind in _ENCODER:
            self._define(kind, command.values)
        elif kind == CommandKind.CONFIGURE_SONAR:
            self.sonar.configure(command.values[0], command.values[1:], self.now_s)
        elif kind == CommandKind.CONFIGURE_WATCHDOG:
            self._watchdog_s = float(command.values[0])

    def reply(self, kind: CommandKind) -> Frame:
        """Return the reply to a command of ``kind``, as of now."""
        make = state_to_frame if kind in STATE_REPLIES else readings_to_frame
        return make(self.state(), kind)

    def waited(self) -> Frame | None:
        """Return the reply to WS once the base stands or the wait has lasted long enough."""
        if self._waiting_until_s is None or (self.moving and self.now_s < self._waiting_until_s):
            return None
        self._waiting_until_s = None
        return self.reply(CommandKind.WAIT_STOPPED)

    def state(self) -> State:
        """Return the whole state."""
        pose, wheels, volts = self._floor.encoder_pose, self._floor.wheels, self._floor.volts
        return State(
            sonar=tuple(self.sonar.registers),
            bumper=1 if self.now_s - self._bumped_s <= self._config.bumper_hold_s else 0,
            x=_overflowing(pose.x / METRES_PER_UNIT),
            y=_overflowing(pose.y / METRES_PER_UNIT),
            heading=round(pose.theta / RADIANS_PER_UNIT) % FULL_TURN,
            right=speed_units(wheels.right),
            left=speed_units(wheels.left),
            motor=motor_byte(MotorStatus(self.moving, BATTERY_HIGH, False, False, self.emergency_stop)),
            board_ms=self.board_ms,
            processor_raw=raw_volts(volts, PROCESSOR_DIVIDER),
            motor_raw=raw_volts(volts, MOTOR_DIVIDER),
        )

    def _move(self, kind: CommandKind, values: tuple[int, ...]) -> None:
        drive = self._drive
        if kind in (CommandKind.STOP, CommandKind.LIMP):
            drive.stop(limp=kind == CommandKind.LIMP)
            return
        wheels = Wheels(values[0] * METRES_PER_UNIT, values[1] * METRES_PER_UNIT)
        if kind == CommandKind.VELOCITY:
            drive.velocity(wheels)
        elif kind == CommandKind.MOVE:
            drive.move(wheels)
        elif kind == CommandKind.SPEED:
            drive.move_speed = wheels
        else:
            drive.acceleration_m_s2 = max(METRES_PER_UNIT, *wheels)

    def _define(self, kind: CommandKind, values: tuple[int, ...]) -> None:
        """Set what the encoders show; the base itself stays where it is."""
        pose = self._floor.encoder_pose
        if kind == CommandKind.DEFINE_POSITION:
            pose = SE2(values[0] * METRES_PER_UNIT, values[1] * METRES_PER_UNIT, pose.theta)
        elif kind == CommandKind.DEFINE_ANGLE:
            pose = SE2(pose.x, pose.y, values[0] * RADIANS_PER_UNIT)
        else:
            pose = SE2()
        self._floor.encoder_pose = pose

    def _tick(self) -> None:
        silent_s = self.now_s - self._fed_s
        if self._watchdog_s and silent_s >= self._watchdog_s and self._drive.wants_to_move:
            self._drive.stop()
            self.aborts += 1
        self._floor.drive(self._drive.tick(self._tick_s, braked=self.emergency_stop), self._tick_s)
        self._ticks += 1
        if self._floor.bumped:
            self._bumped_s = self.now_s
            self._drive.speed = self._floor.wheels
        self.sonar.tick(self.now_s, self._floor.range_m)


MOTION = frozenset(
    {
        CommandKind.ACCELERATION,
        CommandKind.SPEED,
        CommandKind.MOVE,
        CommandKind.VELOCITY,
        CommandKind.STOP,
        CommandKind.LIMP,
    }
)
_ENCODER = frozenset({CommandKind.DEFINE_POSITION, CommandKind.DEFINE_ANGLE, CommandKind.ZERO})


def _overflowing(units: float) -> int:
    """Return a counter that begins anew at the other end of its range (how the real one overflows is not known)."""
    return (round(units) + SIGNED_MAX) % (2 * SIGNED_MAX + 1) - SIGNED_MAX
