"""The guard against its rules, stated anew over the whole history of what it was told."""

import dataclasses
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.motion_guard import STILL, Hold, MotionGuard
from scout_driver.protocol.replies import MotorStatus, State, motor_byte

CONFIG = DriverConfig(bumper_mask=0b0110, command_timeout_s=0.4, line_timeout_s=0.6)
SILENCE_S = CONFIG.line_timeout_s
FAST = Velocity(5.0, -9.0)
STOP_BIT = motor_byte(MotorStatus(moving=True, battery=2, plugged_in=True, charging=True, emergency_stop=True))
NO_STOP = motor_byte(MotorStatus(moving=True, battery=3, plugged_in=True, charging=True, emergency_stop=False))


def state(*, emergency: bool = False, bumper: int = 0) -> State:
    """Return a state whose every other bit is as misleading as can be."""
    return State((255,) * 16, bumper, 0, 0, 0, 0, 0, motor=STOP_BIT if emergency else NO_STOP)


class Heard(NamedTuple):
    """A state the guard was told of."""

    when_s: float
    emergency: bool
    contact: bool


class Said(NamedTuple):
    """A command the guard was given."""

    when_s: float
    velocity: Velocity


@dataclass
class History:
    """All that a guard was told, in order, and what follows from its rules by looking back over it."""

    config: DriverConfig
    now_s: float = 0.0
    events: list[Heard | Said] = field(default_factory=list)

    def states(self) -> list[Heard]:
        """Return the states heard."""
        return [event for event in self.events if isinstance(event, Heard)]

    def command(self) -> Velocity:
        """Return the command in force: the last one, if it is fresh and younger than the last silence of the base."""
        states = self.states()
        heard_s = [-math.inf, *(heard.when_s for heard in states)]
        first = [
            state
            for state, before_s in zip(states, heard_s, strict=False)
            if state.when_s - before_s > self.config.line_timeout_s
        ]
        since = self.events.index(first[-1])
        said = [event for event in self.events[since:] if isinstance(event, Said)]
        fresh = bool(said) and self.now_s - said[-1].when_s <= self.config.command_timeout_s
        return said[-1].velocity if fresh else STILL

    def stopped(self) -> bool:
        """Tell whether an emergency stop is pressed, or nobody has commanded to stand still since its release."""
        pressed = [i for i, event in enumerate(self.events) if isinstance(event, Heard) and event.emergency]
        if not pressed:
            return False
        after = self.events[pressed[-1] + 1 :]
        released = next((i for i, event in enumerate(after) if isinstance(event, Heard)), len(after))
        return not any(isinstance(event, Said) and event.velocity == STILL for event in after[released:])

    def slowed(self) -> tuple[bool, bool]:
        """Tell whether a contact stops the base, and whether it leaves it but backing off and turning."""
        states = self.states()
        contacts = [i for i, heard in enumerate(states) if heard.contact]
        if not contacts:
            return False, False
        began = max(i for i in contacts if i - 1 not in contacts)
        stops = self.now_s - states[began].when_s < self.config.bumper_stop_s
        return stops, states[-1].contact or self.now_s - states[contacts[-1]].when_s < self.config.bumper_resume_s

    def allowed(self) -> Velocity:
        """Return what may be asked of the base now."""
        states = self.states()
        contact_stops, contact_slows = self.slowed()
        if not states or self.now_s - states[-1].when_s > self.config.line_timeout_s or self.stopped() or contact_stops:
            return STILL
        forward, turn = self.command()
        forward = max(-self.config.forward_max_m_s, min(forward, 0.0 if contact_slows else self.config.forward_max_m_s))
        turn_max = self.config.bumper_turn_rad_s if contact_slows else self.config.turn_max_rad_s
        if contact_slows:
            forward = max(-self.config.bumper_reverse_m_s, forward)
        return Velocity(forward, max(-turn_max, min(turn, turn_max)))


TICK_S = 0.125
"""A power of two, so that the ages of both sides are the same to the last bit."""
COMMANDS = st.sampled_from(
    [STILL, FAST, Velocity(-5.0, 9.0), Velocity(0.3, 0.0), Velocity(-0.3, 0.2), Velocity(0.0, 0.2)]
)
QUICK = dataclasses.replace(CONFIG, bumper_stop_s=0.0, bumper_resume_s=0.0)
"""A contact is over, for the guard, with its end."""
STATES = st.tuples(st.sampled_from([False, False, True]), st.sampled_from([0, 0, 0b0001, 0b0100, 0b1010]))


@given(
    st.sampled_from([CONFIG, QUICK]), st.lists(st.tuples(st.integers(0, 3), st.one_of(COMMANDS, STATES)), max_size=40)
)
def test_whatever_happened_only_what_the_rules_allow_is_asked_of_the_base(
    config: DriverConfig,
    events: list[tuple[int, Velocity | tuple[bool, int]]],
) -> None:
    guard, history = MotionGuard(config), History(config)
    guard.enabled = True
    for ticks, event in events:
        for _ in range(ticks):
            history.now_s += TICK_S
            assert guard.allowed(history.now_s) == history.allowed()
        if isinstance(event, Velocity):
            guard.command(event, history.now_s)
            history.events.append(Said(history.now_s, event))
        else:
            emergency, bumper = event
            guard.answered(state(emergency=emergency, bumper=bumper), history.now_s)
            history.events.append(Heard(history.now_s, emergency, bumper & config.bumper_mask != 0))
        assert guard.allowed(history.now_s) == history.allowed()


def obeying(guard: MotionGuard) -> None:
    """Bring a guard to where it obeys a fast command."""
    guard.enabled = True
    guard.answered(state(), 0.0)
    guard.command(FAST, 0.0)
    assert guard.allowed(0.0) == Velocity(CONFIG.forward_max_m_s, -CONFIG.turn_max_rad_s)


@pytest.mark.parametrize("no_number", [Velocity(math.nan, 0.1), Velocity(0.1, -math.inf), Velocity(math.inf, math.nan)])
def test_a_command_that_is_no_number_stands_still(no_number: Velocity) -> None:
    guard = MotionGuard(CONFIG)
    obeying(guard)
    guard.command(no_number, 0.1)
    assert guard.allowed(0.1) == STILL


def test_each_reason_to_hold_is_named_the_gravest_first() -> None:
    guard = MotionGuard(CONFIG)
    assert guard.hold(0.0) is Hold.DISABLED
    obeying(guard)
    assert guard.hold(0.0) is None
    assert guard.hold(CONFIG.command_timeout_s + 0.01) is Hold.NO_COMMAND
    assert guard.hold(SILENCE_S + 0.01) is Hold.LINE
    guard.answered(state(bumper=CONFIG.bumper_mask), 0.1)
    assert guard.hold(0.1) is Hold.BUMPER
    guard.answered(state(emergency=True, bumper=CONFIG.bumper_mask), 0.1)
    assert guard.hold(0.1) is Hold.EMERGENCY_STOP
    guard.answered(state(), 0.2)
    assert guard.hold(0.2) is Hold.EMERGENCY_RELEASED
    guard.limp = True
    assert guard.hold(0.2) is Hold.LIMP
    guard.enabled = False
    assert guard.hold(0.2) is Hold.DISABLED


@pytest.mark.parametrize("hold", ["enabled", "limp"])
def test_neither_an_inactive_nor_a_limp_base_is_moved(hold: str) -> None:
    guard = MotionGuard(CONFIG)
    obeying(guard)
    setattr(guard, hold, not getattr(guard, hold))
    assert guard.allowed(0.1) == STILL


def test_a_moving_command_cut_off_is_counted_once() -> None:
    guard = MotionGuard(CONFIG)
    obeying(guard)
    guard.answered(state(emergency=True), 0.1)
    for when_s in (0.1, 0.2, 0.3):
        guard.allowed(when_s)
    assert guard.stops == 1
