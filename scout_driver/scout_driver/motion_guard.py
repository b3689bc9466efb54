"""What motion is allowed at this moment: the one place that decides, and it starts from standing still.

Nothing the base says ever adds motion here; its reports can only take motion away.
"""

import math
from enum import Enum

from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.protocol.replies import State

STILL = Velocity()


class Hold(Enum):
    """Why the base is being held."""

    NO_COMMAND = "no command"
    LINE = "no answer from the base"
    BUMPER = "bumper"
    EMERGENCY_STOP = "emergency stop"
    EMERGENCY_RELEASED = "emergency stop released, first command to stand still"
    DISABLED = "not active"
    LIMP = "limp"


class MotionGuard:
    """Holds the last command and everything that forbids it."""

    def __init__(self, config: DriverConfig) -> None:
        """Begin disabled."""
        self._config = config
        self._command = STILL
        self._commanded_s = -math.inf
        self._answered_s = -math.inf
        self._pressed = False
        self._contact_s = self._contact_began_s = -math.inf
        self._emergency = self._released = False
        self.enabled = False
        """Whether commands are obeyed at all (the node is active)."""
        self.limp = False
        """Whether the motors are off, so that a person can push the base."""
        self.stops = 0
        """Times a moving command was cut off by one of the holds."""
        self._was_moving = False

    def command(self, velocity: Velocity, now_s: float) -> None:
        """Take a new command (m/s, rad/s); values that are not finite count as a command to stand still.

        A released emergency stop goes on holding until somebody has said to stand still: a commander that
        talked on all the while must not set the base in motion by the hand on the button.
        """
        self._released = self._released and velocity != STILL
        finite = math.isfinite(velocity.forward) and math.isfinite(velocity.turn)
        self._command = self._clamped(velocity) if finite else STILL
        self._commanded_s = now_s

    def forget_command(self) -> None:
        """Drop the last command: what was asked for before an interruption is not carried out after it."""
        self._command, self._commanded_s = STILL, -math.inf

    def answered(self, state: State, now_s: float) -> None:
        """Take a state that has just come from the base."""
        if now_s - self._answered_s > self._config.line_timeout_s:
            self.forget_command()
        self._answered_s = now_s
        emergency = state.motor_status.emergency_stop
        pressed = bool(state.bumper & self._config.bumper_mask)
        if pressed:
            self._contact_began_s = self._contact_began_s if self._pressed else now_s
            self._contact_s = now_s
        self._released = not emergency and (self._released or self._emergency)
        self._pressed, self._emergency = pressed, emergency

    def hold(self, now_s: float) -> Hold | None:
        """Return the first reason to hold the base, None if there is none."""
        reasons = {
            Hold.DISABLED: not self.enabled,
            Hold.LIMP: self.limp,
            Hold.EMERGENCY_STOP: self._emergency,
            Hold.EMERGENCY_RELEASED: self._released,
            Hold.LINE: now_s - self._answered_s > self._config.line_timeout_s,
            Hold.NO_COMMAND: now_s - self._commanded_s > self._config.command_timeout_s,
            Hold.BUMPER: now_s - self._contact_began_s < self._config.bumper_stop_s
            or (self._command != STILL and self._after_contact(now_s) == STILL),
        }
        return next((reason for reason, holds in reasons.items() if holds), None)

    def allowed(self, now_s: float) -> Velocity:
        """Return the velocity that may be asked of the base now."""
        hold = self.hold(now_s)
        if hold is not None:
            self.stops += self._was_moving
            self._was_moving = False
            return STILL
        self._was_moving = self._command != STILL
        return self._after_contact(now_s)

    def _after_contact(self, now_s: float) -> Velocity:
        """Return what a contact leaves of the command: backing off and turning, slowly, until it is long past."""
        config, command = self._config, self._command
        if not self._pressed and now_s - self._contact_s >= config.bumper_resume_s:
            return command
        turn = config.bumper_turn_rad_s
        return Velocity(min(max(command.forward, -config.bumper_reverse_m_s), 0.0), min(max(command.turn, -turn), turn))

    def _clamped(self, velocity: Velocity) -> Velocity:
        forward, turn = self._config.forward_max_m_s, self._config.turn_max_rad_s
        return Velocity(min(max(velocity.forward, -forward), forward), min(max(velocity.turn, -turn), turn))
