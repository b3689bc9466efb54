"""The guard of the body: no command that it lets through runs the body into what is known."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hslam_gvg.guards.body_guard import limited
from hslam_types.se2 import SE2
from hslam_types.sensing import Velocity

ROOM_M = 0.215
obstacle = st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9)).filter(lambda p: math.hypot(*p) > ROOM_M + 0.01)


def after(command: Velocity, seconds: float) -> SE2:
    """Return where a command leads from the origin, by small steps."""
    pose, step = SE2(), seconds / 50
    for _ in range(50):
        pose = pose @ SE2(command.forward * step, 0.0, command.turn * step)
    return pose


@given(st.lists(obstacle, min_size=1, max_size=12), st.floats(-0.4, 0.4), st.floats(-1.2, 1.2))
def test_the_body_stays_clear_until_the_next_command(
    points: list[tuple[float, float]], forward: float, turn: float
) -> None:
    command, _ = limited(Velocity(forward, turn), SE2(), np.array(points), ROOM_M)
    for seconds in (0.12, 0.24):
        pose = after(command, seconds)
        least = min(math.hypot(x - pose.x, y - pose.y) for x, y in points)
        now = min(math.hypot(x, y) for x, y in points)
        # The foreseen arc is a chord: a few millimetres of it may bulge.
        assert least > min(ROOM_M, now) - 0.01


def test_a_wall_ahead_stops_and_says_so() -> None:
    wall = np.array([[0.23, y] for y in np.linspace(-0.5, 0.5, 21)])
    assert limited(Velocity(0.4, 0.0), SE2(), wall, ROOM_M) == (Velocity(0.0, 0.0), True)
    assert limited(Velocity(-0.4, 0.0), SE2(), wall, ROOM_M) == (Velocity(-0.4, 0.0), False)


def test_near_a_wall_the_command_is_slowed_before_it_is_stopped() -> None:
    wall = np.array([[0.35, y] for y in np.linspace(-0.5, 0.5, 21)])
    command, blocked = limited(Velocity(0.4, 0.2), SE2(), wall, ROOM_M)
    assert not blocked
    assert 0.0 < command.forward < 0.4
    assert math.isclose(command.turn / command.forward, 0.5)


def test_turning_on_the_spot_is_free() -> None:
    assert limited(Velocity(0.0, 1.0), SE2(), np.array([[0.2, 0.0]]), ROOM_M) == (Velocity(0.0, 1.0), False)


def test_a_body_too_near_may_move_away_but_no_nearer() -> None:
    beside = np.array([[0.0, 0.2]])
    assert limited(Velocity(0.2, -0.5), SE2(), beside, ROOM_M)[1] is False
    ahead = np.array([[0.2, 0.0]])
    assert limited(Velocity(0.2, 0.0), SE2(), ahead, ROOM_M)[1] is True
    assert limited(Velocity(-0.2, 0.0), SE2(), ahead, ROOM_M)[1] is False


def test_an_arc_is_followed_to_its_own_side() -> None:
    beside = np.array([[0.3, 0.2]])
    left, right = (limited(Velocity(0.4, turn), SE2(), beside, ROOM_M)[0] for turn in (1.2, -1.2))
    assert left.forward < 0.4
    assert right == Velocity(0.4, -1.2)


def test_slow_commands_are_looked_at_farther_ahead_in_time_than_fast_ones() -> None:
    """0.7 s at 0.15 m/s come within 0.21 m of the obstacle; 0.5 s at 0.4 m/s within 0.23 m of theirs."""
    assert limited(Velocity(0.15, 0.0), SE2(), np.array([[0.315, 0.0]]), ROOM_M)[0].forward < 0.15
    assert limited(Velocity(0.4, 0.0), SE2(), np.array([[0.43, 0.0]]), ROOM_M)[0].forward == 0.4


def test_who_is_stopped_may_turn_on() -> None:
    assert limited(Velocity(0.4, 0.3), SE2(), np.array([[0.23, 0.0]]), ROOM_M) == (Velocity(0.0, 0.3), True)
