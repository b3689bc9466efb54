"""Pings in memory: who stands still says nothing new; a gap is judged by pings that a wall would have answered."""

import math

import numpy as np
import pytest

from hslam_gvg.ranging.cone_ping import ConePing
from hslam_gvg.ranging.ping_memory import PingMemory

HALF_CONE = math.radians(15.0)
BEGIN, END = np.array([[2.0, -0.5]]), np.array([[2.0, 0.5]])


def ping(x: float, y: float, axis: float, range_m: float) -> ConePing:
    """Return a ping of a sonar with the Scout's cone."""
    return ConePing(x, y, axis, range_m, HALF_CONE)


def test_a_ping_repeated_from_the_same_place_is_not_new() -> None:
    memory = PingMemory(6.0)
    assert memory.is_new(ping(0.0, 0.0, 0.0, 2.0), 0.0)
    assert not memory.is_new(ping(0.01, 0.01, 0.02, 2.03), 0.1)


@pytest.mark.parametrize(
    "other", [ping(0.1, 0.0, 0.0, 2.0), ping(0.0, 0.0, 0.1, 2.0), ping(0.0, 0.0, 0.0, 2.1), ping(0, 0, 0, math.inf)]
)
def test_a_ping_from_elsewhere_or_with_another_answer_is_new(other: ConePing) -> None:
    memory = PingMemory(6.0)
    memory.is_new(ping(0.0, 0.0, 0.0, 2.0), 0.0)
    assert memory.is_new(other, 0.0)


def test_a_repeated_ping_is_remembered_for_longer() -> None:
    memory = PingMemory(6.0)
    memory.is_new(ping(0.0, 0.0, 0.0, 2.0), 0.0)
    memory.is_new(ping(0.0, 0.0, 0.0, 2.0), 4.0)
    assert memory.recent(9.0).shape[1] == 1
    assert memory.recent(10.1).shape[1] == 0


def test_pings_go_through_a_gap_or_end_at_it() -> None:
    memory = PingMemory(6.0)
    memory.is_new(ping(0.0, 0.0, 0.0, 3.0), 0.0)
    memory.is_new(ping(0.0, 0.1, 0.0, math.inf), 0.0)
    memory.is_new(ping(0.0, -0.1, 0.0, 2.05), 0.0)
    through, ended = memory.met(BEGIN, END, 0.0)
    assert (through.tolist(), ended.tolist()) == ([2], [1])


def test_a_ping_that_a_wall_beside_its_axis_would_have_answered_counts() -> None:
    memory = PingMemory(6.0)
    memory.is_new(ping(0.0, 0.48, 0.0, 3.0), 0.0)
    through, _ = memory.met(BEGIN, END, 0.0)
    assert through.tolist() == [1]


def test_a_corner_behind_the_gap_ends_pings() -> None:
    memory = PingMemory(6.0)
    memory.is_new(ping(0.0, 0.0, 0.0, 2.5), 0.0)
    through, ended = memory.met(BEGIN, END, 0.0)
    assert (through.tolist(), ended.tolist()) == ([0], [1])


@pytest.mark.parametrize(
    "past",
    [
        ping(0.0, 0.8, 0.0, 3.0),  # beside the gap
        ping(0.0, 0.7, 0.1, 4.0),  # at its jamb
        ping(1.5, -0.2, math.radians(35.0), 4.0),  # only the rim of its cone meets a wall there squarely
        ping(1.0, -1.3, math.radians(50.0), 4.0),  # a wall there would not have answered
        ping(-0.5, 0.0, 0.0, 4.0),  # from too far
        ping(3.0, 0.0, 0.0, 4.0),  # away from it
    ],
)
def test_pings_that_a_wall_would_not_have_answered_say_nothing(past: ConePing) -> None:
    memory = PingMemory(6.0)
    memory.is_new(past, 0.0)
    through, ended = memory.met(BEGIN, END, 0.0)
    assert (through.tolist(), ended.tolist()) == ([0], [0])


@pytest.mark.parametrize(("heard_m", "through"), [(2.24, 0), (2.27, 1)])
def test_a_ping_is_past_a_narrow_gap_by_a_quarter_of_a_metre(heard_m: float, through: int) -> None:
    memory = PingMemory(6.0)
    memory.is_new(ping(0.0, 0.0, 0.0, heard_m), 0.0)
    assert memory.met(np.array([[2.0, -0.1]]), np.array([[2.0, 0.1]]), 0.0)[0].tolist() == [through]


def test_a_ping_said_again_when_it_has_been_forgotten_is_new() -> None:
    memory = PingMemory(6.0)
    memory.is_new(ping(0.0, 0.0, 0.0, 2.0), 0.0)
    assert memory.is_new(ping(0.0, 0.0, 0.0, 2.0), 6.5)
