"""The stall watch: who is told to drive and does not move is held; whoever moves, in whatever direction, is not."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_gvg.stall import HELD, LEAST_M_S, STALL_S, StallWatch
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample, Velocity

STEP_S = 0.12
STEP_NS = 120_000_000
STEPS = math.ceil(STALL_S / STEP_S)
"""Cycles until being held is seen."""


def watch(told: list[float], moved: list[tuple[float, float]], heading: float = 0.0) -> list[bool]:
    """Return when a stall is seen: by cycle what is commanded (m/s), and the motion in base_link that answers (m)."""
    stall, pose = StallWatch(), SE2(1.0, 2.0, heading)
    stall.sees(OdometrySample(0, pose))
    seen = []
    for i, (speed, motion) in enumerate(zip(told, moved, strict=True)):
        stall.tell(Velocity(speed))
        pose = SE2(*pose.apply(*motion), pose.theta)
        seen.append(stall.sees(OdometrySample((i + 1) * STEP_NS, pose)))
    return seen


@pytest.mark.parametrize("speed", [0.4, -0.4])
@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_motion_in_any_direction_is_motion(speed: float, heading: float, direction: float) -> None:
    """Slipping past an edge, or carried along in a curve: the wheels turn, whatever is ahead of them."""
    for share, held in ((1.0, False), (1.01 * HELD, False), (0.5 * HELD, True)):
        step_m = share * abs(speed) * STEP_S
        motion = step_m * math.cos(direction), step_m * math.sin(direction)
        seen = watch([speed] * STEPS, [motion] * STEPS, heading)
        assert seen == [False] * (STEPS - 1) + [held]


def test_being_held_counts_from_where_it_began() -> None:
    moved = [(0.048, 0.0)] * 2 + [(0.0, 0.0)] * (STEPS - 1) + [(0.048, 0.0)] + [(0.0, 0.0)] * STEPS
    seen = watch([0.4] * len(moved), moved)
    assert [i for i, stalled in enumerate(seen) if stalled] == [len(moved) - 1]


@pytest.mark.parametrize(("speed", "noticed"), [(LEAST_M_S, True), (0.99 * LEAST_M_S, False), (-LEAST_M_S, True)])
def test_commands_too_slow_for_the_encoders_say_nothing(speed: float, noticed: bool) -> None:
    assert watch([speed] * STEPS, [(0.0, 0.0)] * STEPS)[-1] is noticed


def test_whoever_stays_held_is_noticed_again_and_again() -> None:
    seen = watch([0.4] * 3 * STEPS, [(0.0, 0.0)] * 3 * STEPS)
    assert [i for i, stalled in enumerate(seen) if stalled] == [STEPS - 1, 2 * STEPS - 1, 3 * STEPS - 1]


def test_standing_between_two_pushes_does_not_hide_that_the_body_is_held_in_one_direction() -> None:
    stall = StallWatch()
    for speed, direction in ((0.2, 1.0), (-0.2, -1.0), (0.0, 1.0)):
        stall.tell(Velocity(speed))
        assert stall.direction == direction


def test_being_held_is_a_matter_of_time_not_of_cycles() -> None:
    stall = StallWatch()
    stall.sees(OdometrySample(0, SE2()))
    stall.tell(Velocity(0.4))
    assert not stall.sees(OdometrySample(round(STALL_S * 1e9) - 1, SE2()))
    assert stall.sees(OdometrySample(round(STALL_S * 1e9), SE2()))


def test_a_new_goal_begins_anew() -> None:
    stall = StallWatch()
    stall.sees(OdometrySample(0, SE2()))
    stall.tell(Velocity(0.4))
    stall.sees(OdometrySample(round(STALL_S * 1e9) - 1, SE2()))
    stall.reset()
    assert not stall.sees(OdometrySample(round(STALL_S * 1e9), SE2()))
    stall.tell(Velocity(0.4))
    assert not stall.sees(OdometrySample(round(1.9 * STALL_S * 1e9), SE2()))
