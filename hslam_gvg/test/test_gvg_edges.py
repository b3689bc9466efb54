"""Edges answer seldom: three that agree make one, if not too many pings listened there in vain."""

import math

import numpy as np
import pytest

from hslam_gvg.ranging.cone_ping import ConePing
from hslam_gvg.ranging.edges import CLEARED, SUSPECTED_M, edges, suspicious
from hslam_gvg.ranging.ping_memory import PingMemory
from hslam_gvg.ranging.reflectors import OFFSETS, Reflectors, _explained, _pieces
from hslam_types.se2 import Array

HALF_CONE = math.radians(15.0)
EDGE = (1.0, 0.3)


class Ears:
    """A sonar that looks along x, carried along x: what it hears goes into reflectors."""

    def __init__(self) -> None:
        """Begin deaf."""
        self.pings, self.reflectors = PingMemory(6.0), Reflectors(3.5, 6.0, 2.0)

    def ping(self, x: float, heard: float, axis: float = 0.0, y: float = 0.0) -> None:
        """Fire from a place along an axis."""
        ping = ConePing(x, y, axis, heard, HALF_CONE)
        if self.pings.is_new(ping, 0.0):
            self.reflectors.weigh(self.pings.newest())
            self.reflectors.add(ping, self.pings.recent(0.0), 0.0)

    def pass_by(self, answers: set[int], count: int = 10) -> None:
        """Drive towards the edge; it answers some pings, the others hear nothing."""
        for k in range(count):
            x, away = 0.06 * k, math.hypot(EDGE[0] - 0.06 * k, EDGE[1])
            self.ping(x, away if k in answers else math.inf, math.atan2(EDGE[1], EDGE[0] - x) - 0.05)


def near_edge(points: Array) -> Array:
    """Return how far points are from the edge (m)."""
    return np.hypot(points[:, 0] - EDGE[0], points[:, 1] - EDGE[1])


def test_an_edge_that_answers_three_pings_in_ten_is_an_obstacle() -> None:
    ears = Ears()
    ears.pass_by({0, 4, 8})
    points = ears.reflectors.points(0.0)
    assert len(points) >= 1
    assert near_edge(points).max() < 0.15


def test_two_that_agree_are_none_but_are_suspected() -> None:
    ears = Ears()
    ears.pass_by({0, 4}, 6)
    assert len(ears.reflectors.points(0.0)) == 0
    suspects = ears.reflectors.suspects(0.0)
    assert near_edge(suspects).min() < 0.1


def test_a_place_that_many_pings_listened_to_in_vain_is_no_edge() -> None:
    echoes = np.array([[0.0, 0.0, 0.0, 1.0, HALF_CONE, 0.0]] * 3).T
    echoes[0] = 0.0, 0.2, 0.4
    echoes[3] = 1.0, 0.8, 0.6
    candidates = np.stack((np.full((3, 1), 1.0), np.zeros((3, 1))))
    few, many = np.full((3, 1), 13.0), np.full((3, 1), 14.0)
    assert edges(candidates, echoes, few)[1].tolist() == [True] * 3
    assert edges(candidates, echoes, many)[1].tolist() == [False] * 3


def test_an_echo_has_one_cause() -> None:
    # Five echoes meet at (1, 0), and three of them, less surely, at (1, 0.2) as well.
    x = np.array([0.0, 0.1, 0.2, 0.7, 0.8])
    echoes = np.stack((x, 0 * x, 0 * x, 1.0 - x, np.full(5, HALF_CONE), 0 * x))
    candidates = np.zeros((2, 5, 2))
    candidates[0] = 1.0
    candidates[1] = 0.0, 0.2
    places, explained = edges(candidates, echoes, np.zeros((5, 2)))
    assert places.tolist() == [[1.0, 0.0]]
    assert explained.all()


@pytest.mark.parametrize(("x", "axis", "heard"), [(0.4, 0.0, 0.8), (0.4, 0.6, 0.6)])
def test_echoes_agree_only_in_their_cone_at_their_range(x: float, axis: float, heard: float) -> None:
    echoes = np.array([[0.0, 0.0, 0.0, 1.0, HALF_CONE, 0.0], [0.2, 0.0, 0.0, 0.8, HALF_CONE, 0.0]])
    other = np.array([[x, 0.0, axis, heard, HALF_CONE, 0.0]])
    candidates = np.stack((np.full((3, 1), 1.0), np.zeros((3, 1))))
    assert not edges(candidates, np.concatenate((echoes, other)).T, np.zeros((3, 1)))[1].any()


def test_an_echo_is_suspected_until_enough_pings_went_past_it() -> None:
    candidates = np.zeros((2, 3, len(OFFSETS)))
    ranges = np.array([SUSPECTED_M - 0.1, SUSPECTED_M - 0.1, SUSPECTED_M + 0.1])
    silent = np.zeros((3, len(OFFSETS)))
    silent[1] = CLEARED
    assert len(suspicious(candidates, ranges, silent)) == len(OFFSETS)


def test_what_a_wall_explains_is_no_suspect() -> None:
    ears = Ears()
    for x in np.arange(0.0, 1.2, 0.07):  # a wall 0.8 m to the left
        ears.ping(float(x), 0.8, 0.5 * math.pi)
    ears.reflectors.points(0.0)
    ears.ping(0.55, 0.79, math.radians(65.0))  # the rim of its lobe
    assert len(ears.reflectors.suspects(0.0)) == 0
    ears.ping(0.55, 0.5, math.radians(65.0))
    assert len(ears.reflectors.suspects(0.0)) > 0


def test_a_ping_past_it_along_its_normal_outweighs_two_that_agree() -> None:
    ears = Ears()
    for x in (0.0, 0.1, 0.2):
        ears.ping(x, 2.35 - x)
    assert len(ears.reflectors.points(0.0)) == 3
    for axis in (-0.2, 0.0, 0.2):
        ears.ping(0.3, math.inf, axis)
    assert len(ears.reflectors.points(0.0)) == 0


def test_a_wall_is_heard_in_pieces() -> None:
    wall = [(0.3 * k, 1.0) for k in range(4)]
    places = np.array([*wall, (0.5, 0.0), (0.7, 0.0)])
    assert _pieces(places).tolist() == [False, True, True, False, False, False]


def test_an_echo_is_no_support_of_itself() -> None:
    ears = Ears()
    ears.ping(0.0, 1.0)
    assert not ears.reflectors._support[0].any()
    ears.ping(0.0, 1.0, y=0.1)
    assert ears.reflectors._support[1].any()


@pytest.mark.parametrize(
    ("off_axis", "heard_m", "explained"),
    [(15.0, 2.0, True), (25.0, 2.0, False), (35.0, 2.0, False), (35.0, 1.2, True), (50.0, 1.2, False)],
)
def test_a_wall_explains_echoes_of_a_lobe_and_near_ones_of_a_side_lobe(
    off_axis: float, heard_m: float, explained: bool
) -> None:
    wall = heard_m * np.array([[math.cos(math.radians(off_axis)), math.sin(math.radians(off_axis))]])
    echo = np.array([[0.0], [0.0], [0.0], [heard_m]])
    assert _explained(echo, np.full((1, 2), math.inf), wall)[0] == explained


def test_no_place_explains_itself() -> None:
    echo, wall = np.array([[0.0], [0.0], [0.0], [2.0]]), np.array([[2.0, 0.0]])
    assert not _explained(echo, wall + [0.0, 0.1], wall)[0]  # noqa: RUF005 - a sum
    assert _explained(echo, wall + [0.0, 0.2], wall)[0]  # noqa: RUF005 - a sum


@pytest.mark.parametrize(("travel_m", "minded"), [(2.9, True), (3.1, False)])
def test_what_nothing_explains_is_minded_for_three_metres_of_travel(travel_m: float, minded: bool) -> None:
    ears = Ears()
    ears.ping(0.0, 1.0)
    assert bool(len(ears.reflectors.suspects(travel_m))) == minded
