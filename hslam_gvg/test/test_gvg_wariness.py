"""What an unexplained echo does to the pace: only in the way of the body, and down to a creep."""

import math

import numpy as np
import pytest

from hslam_gvg.guards.wariness import CREEP_FROM_M, CREEP_M_S, wary
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import Velocity

BODY_M = 0.19
FAST = Velocity(0.4, 0.2)


def at(*places: tuple[float, float]) -> Array:
    """Return places as an array."""
    return np.array(places).reshape(-1, 2)


def test_nothing_suspected_leaves_the_command_alone() -> None:
    assert wary(FAST, SE2(), at(), BODY_M) == FAST


@pytest.mark.parametrize("place", [(0.5, 0.3), (0.5, -0.3), (-0.5, 0.0)])
def test_beside_and_behind_the_body_nothing_is_minded(place: tuple[float, float]) -> None:
    assert wary(FAST, SE2(), at(place), BODY_M) == FAST


def test_the_body_creeps_towards_what_may_be_there_and_steers_as_it_would() -> None:
    near = wary(FAST, SE2(), at((0.4, 0.2)), BODY_M)
    assert near.forward == CREEP_M_S
    assert near.turn / near.forward == pytest.approx(FAST.turn / FAST.forward)


def test_from_farther_off_it_slows_down_in_time() -> None:
    room_m = CREEP_FROM_M + 0.25
    slowed = wary(FAST, SE2(), at((BODY_M + room_m, 0.0), (3.0, 0.0)), BODY_M)
    assert slowed.forward == pytest.approx(0.2)
    assert wary(FAST, SE2(), at((BODY_M + CREEP_FROM_M + 0.6, 0.0)), BODY_M) == FAST


def test_backwards_what_lies_behind_counts() -> None:
    back = Velocity(-0.12, 0.0)
    assert wary(back, SE2(), at((-0.4, 0.0)), BODY_M).forward == -CREEP_M_S
    assert wary(back, SE2(), at((0.4, 0.0)), BODY_M) == back


def test_the_way_is_that_of_the_heading() -> None:
    pose = SE2(1.0, 2.0, 0.5 * math.pi)
    assert wary(FAST, pose, at((1.0, 2.4)), BODY_M).forward == CREEP_M_S
    assert wary(FAST, pose, at((1.4, 2.0)), BODY_M) == FAST


def test_turning_on_the_spot_is_free() -> None:
    assert wary(Velocity(0.0, 1.0), SE2(), at((0.25, 0.0)), BODY_M) == Velocity(0.0, 1.0)
