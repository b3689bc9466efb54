"""Along the edge: the pace where a side opens, the course by the graph, and how near a node the path must have come."""

import math

import pytest

from hslam_gvg.config import GvgConfig
from hslam_gvg.homing import Homing
from hslam_gvg.node_detector import AHEAD_M, NodeDetector
from hslam_gvg.recovery import Recovery
from hslam_gvg.reduced_graph import ReducedGraph, ReducedNode
from hslam_gvg.situation import Situation
from hslam_gvg.tracing import OPENING, SLOWEST, SLOWING, Tracing
from hslam_gvg.voronoi_graph import VoronoiGraph
from hslam_types.se2 import SE2, wrap

CONFIG = GvgConfig()
PASSING_M = 2.0
"""The way along an opening of a corridor's width."""
STEP_M = 0.048
"""At the cruising speed."""


def paces(usual_m: float, clearances_m: list[float]) -> list[float]:
    """Return the shares of the speed along a stretch with these clearances, after one with the usual clearance."""
    now = Situation(CONFIG)
    now.room_m = usual_m
    tracing = Tracing(now, Recovery(now, Homing(now)))
    return [tracing._opening(room_m) for room_m in clearances_m]


def test_where_a_side_opens_the_robot_slows_and_stays_slow_until_it_is_past() -> None:
    shares = paces(1.0, [2.0] * round(PASSING_M / STEP_M))
    assert shares[0] == shares[-1] == SLOWEST


def test_a_wider_place_becomes_usual_in_the_end() -> None:
    assert paces(1.0, [1.5] * 500)[-1] == 1.0


def test_a_narrower_place_is_usual_after_a_few_metres_so_that_the_next_opening_is_noticed() -> None:
    into_narrow = [1.0] * round(2.5 / STEP_M)
    shares = paces(2.0, [*into_narrow, 1.5])
    assert shares[:-1] == [1.0] * len(into_narrow)
    assert shares[-1] < 0.5


@pytest.mark.parametrize("growth", [1.0, OPENING, OPENING + 0.1, OPENING + 0.2])
def test_the_pace_falls_with_the_growth_of_the_clearance(growth: float) -> None:
    assert paces(1.0, [growth]) == [pytest.approx(max(SLOWEST, min(1.0, 1.0 - SLOWING * (growth - OPENING))))]


def graph_of(*nodes: ReducedNode) -> ReducedGraph:
    """Return a graph that holds these nodes."""
    graph = ReducedGraph(VoronoiGraph([], [], [], set(), {}), CONFIG.dead_end_m, CONFIG.chord_m)
    graph.nodes = [*nodes]
    return graph


def junction(x: float, y: float, clearance_m: float = 1.0) -> ReducedNode:
    return ReducedNode(x, y, clearance_m, (-1.5, 0.0, 3.0))


PATH = [(0.1 * i, 0.0) for i in range(31)]
"""Driven along the x axis to (3, 0)."""
HERE = SE2(3.0, 0.0, 0.0)


def found(*nodes: ReducedNode, handled: tuple[tuple[float, float], ...] = ()) -> ReducedNode | None:
    return NodeDetector(CONFIG).passed(graph_of(*nodes), HERE, PATH, list(handled))


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("clearance_m", "off_m", "is_passed"),
    [(0.5, 0.59, True), (0.5, 0.61, False), (2.0, 1.19, True), (2.0, 1.21, False)],
)
def test_the_path_must_have_come_near_to_a_node_the_nearer_the_tighter_it_is(
    side: float, clearance_m: float, off_m: float, is_passed: bool
) -> None:
    """Else a node of the corridor beside this one is taken for one of this edge."""
    assert (found(junction(2.0, side * off_m, clearance_m)) is not None) is is_passed


def test_a_node_near_the_robot_need_not_be_near_its_path() -> None:
    """The robot itself is where the path has yet to be noted."""
    detector, node = NodeDetector(CONFIG), junction(3.0, 0.5)
    assert detector.passed(graph_of(node), HERE, [(0.0, 0.0)], []) == node
    assert detector.passed(graph_of(node), HERE, [], []) == node


@pytest.mark.parametrize(("ahead_m", "is_passed"), [(AHEAD_M - 0.01, True), (AHEAD_M + 0.01, False)])
def test_a_node_counts_once_it_is_reached(ahead_m: float, is_passed: bool) -> None:
    assert (found(junction(3.0 + ahead_m, 0.0)) is not None) is is_passed


@pytest.mark.parametrize(("back_m", "is_passed"), [(-0.01, True), (0.01, False)])
def test_a_node_far_behind_is_let_be(back_m: float, is_passed: bool) -> None:
    assert (found(junction(3.0 - CONFIG.look_back_m - back_m, 0.0)) is not None) is is_passed


@pytest.mark.parametrize("clearance_m", [0.5, 2.0])
def test_a_handled_node_hides_what_is_within_its_clearance_or_a_little_more(clearance_m: float) -> None:
    hidden_m = max(CONFIG.suppress_m, clearance_m)
    for off_m, is_passed in ((hidden_m - 0.01, False), (hidden_m + 0.01, True)):
        assert (found(junction(2.5, 0.0, clearance_m), handled=((2.5 - off_m, 0.0),)) is not None) is is_passed


def test_of_two_nodes_passed_the_nearer_is_taken() -> None:
    nearer = junction(2.5, 0.0)
    assert found(junction(1.0, 0.0), nearer) == nearer
    assert found(junction(1.0, 0.0), nearer, handled=((2.5, 0.0),)) == junction(1.0, 0.0)


@pytest.mark.parametrize("back", [0.0, math.pi])
def test_the_course_never_leads_back_where_the_robot_came_from(back: float) -> None:
    now = Situation(CONFIG)
    now.pose = SE2(0.0, 0.0, 0.0)
    now.journey.begin(2.0 * math.cos(back), 2.0 * math.sin(back))
    for share in (1.0, 0.75, 0.5, 0.25, 0.0):
        now.journey.advance(2.0 * share * math.cos(back), 2.0 * share * math.sin(back))
    tracing = Tracing(now, Recovery(now, Homing(now)))
    assert tracing._way_on((back, back + 1.0, back + 1.1)) == back + 1.1
    assert tracing._way_on((back, back - 1.0)) is None
    # On the other side of what lies behind it is the heading that chooses.
    assert tracing._way_on((back + 1.5, back - 1.2)) == min(back + 1.5, back - 1.2, key=lambda way: abs(wrap(way)))
