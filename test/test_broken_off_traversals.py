"""A traversal broken off in the middle of its edge: what the EKF and the atlas make of it.

The robot drives in the simulator; a goal takes the place of the edge that it traces, and an access brings it on.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import pytest

from hslam_atlas.server import AtlasServer
from hslam_ekf.server import EkfOutput, EkfServer
from hslam_gvg.server import GvgServer
from hslam_sim.simulation import SimStep, Simulation
from hslam_sim.worlds import load_world
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.sensing import Velocity

BROKEN_OFF_M = 3.0
"""Length of the traversal when the goal comes."""
PATIENCE_STEPS = 4000
SAME_M = 1.0
"""Two places nearer to each other than this are one, by odometry and by the truth."""


class Cycle(NamedTuple):
    """What the base said in a cycle, and what the GVG level announced."""

    base: SimStep
    events: tuple[GvgEvent, ...]


Told = Callable[[list[Cycle]], list[Cycle]]


class Robot:
    """The simulated robot under its GVG level."""

    def __init__(self) -> None:
        self.simulation, self.gvg = Simulation(load_world("small_world"), seed=1), GvgServer()
        self.cycles: list[Cycle] = []
        self._command: Velocity | None = None

    def step(self) -> tuple[GvgEvent, ...]:
        """Drive one cycle and return its events."""
        base = self.simulation.step(self._command)
        out = self.gvg.step(base.odom, base.sonar)
        self._command = out.command
        self.cycles.append(Cycle(base, out.events))
        return out.events

    def until(self, kind: EventKind) -> GvgEvent:
        """Drive until an event of a kind and return it."""
        for _ in range(PATIENCE_STEPS):
            for event in self.step():
                if event.kind is kind:
                    return event
        raise AssertionError(f"no {kind.name}")


def broken_off(kind: GoalKind) -> list[Cycle]:
    """Trace an edge, break that off by a goal, and go on to another arrival by an access."""
    robot = Robot()
    robot.gvg.start(GvgGoal(GoalKind.ACCESS))
    arrival = robot.until(EventKind.ARRIVAL)
    assert arrival.node is not None
    robot.gvg.start(GvgGoal(GoalKind.TRACE, branch=(arrival.branch + 1) % arrival.node.degree))
    robot.until(EventKind.DEPARTURE)
    while robot.gvg.path_length_m < BROKEN_OFF_M:
        assert not robot.step(), "the edge is too short to be broken off"
    x, y = robot.cycles[-1].base.odom.base_in_odom.apply(0.3, 0.0)
    robot.gvg.start(GvgGoal(kind, x_in_odom=x, y_in_odom=y))
    robot.until(EventKind.LOST)
    if kind is not GoalKind.ACCESS:
        for _ in range(20):
            assert not robot.step()
        robot.gvg.start(GvgGoal(GoalKind.ACCESS))
    robot.until(EventKind.ARRIVAL)
    return robot.cycles


@pytest.fixture(scope="module", params=[GoalKind.STOP, GoalKind.ACCESS, GoalKind.STRAIGHT], ids=lambda kind: kind.name)
def cycles(request: pytest.FixtureRequest) -> list[Cycle]:
    return broken_off(request.param)


def unannounced(cycles: list[Cycle]) -> list[Cycle]:
    """Return the same drive as a level would tell it that announces no loss, as recordings of earlier versions do."""
    return [
        Cycle(base, tuple(event for event in events if event.kind is not EventKind.LOST)) for base, events in cycles
    ]


def mapped(cycles: list[Cycle]) -> list[EkfOutput]:
    """Return what the EKF makes of a drive."""
    ekf = EkfServer()
    return [ekf.step(base.odom, base.landmarks, events) for base, events in cycles]


def atlas_of(cycles: list[Cycle]) -> AtlasServer:
    """Return what the atlas makes of a drive."""
    atlas = AtlasServer()
    for cycle, out in zip(cycles, mapped(cycles), strict=True):
        atlas.step(cycle.events, out.edge_maps, out.links)
    return atlas


def true_place(cycle: Cycle, event: GvgEvent) -> tuple[float, float]:
    """Return where the node of an event truly is (m, map)."""
    assert event.node is not None
    odom_in_map = cycle.base.truth @ cycle.base.odom.base_in_odom.inverse()
    return odom_in_map.apply(event.node.x_in_odom, event.node.y_in_odom)


def test_the_loss_is_announced_once(cycles: list[Cycle]) -> None:
    kinds = [event.kind.name for cycle in cycles for event in cycle.events]
    assert kinds == ["ACCESS", "ARRIVAL", "DEPARTURE", "LOST", "ACCESS", "ARRIVAL"]


def test_no_map_is_made_of_half_an_edge(cycles: list[Cycle]) -> None:
    outputs = mapped(cycles)
    assert not any(out.edge_maps or out.links for out in outputs)
    kinds = [[event.kind for event in cycle.events] for cycle in cycles]
    lost = kinds.index([EventKind.LOST])
    accessed = kinds.index([EventKind.ACCESS], lost)
    assert outputs[lost - 1].traversal >= 0
    assert {out.traversal for out in outputs[lost:accessed]} == {-1}


@pytest.mark.parametrize("told", [list, unannounced], ids=["announced", "unannounced"])
def test_the_next_arrival_is_linked_to_the_node_left_from(cycles: list[Cycle], told: Told) -> None:
    atlas = atlas_of(told(cycles))
    graph = atlas.state.graph
    assert (list(graph.nodes), list(graph.edges)) == ([0, 1], [])
    (link,) = graph.links.values()
    assert (link.from_node, link.to_node) == (0, 1)
    arrivals = [(cycle, event) for cycle in cycles for event in cycle.events if event.kind is EventKind.ARRIVAL]
    first, second = (true_place(*arrival) for arrival in arrivals)
    assert math.hypot(*link.to_in_from.pose[:2]) == pytest.approx(math.dist(first, second), abs=SAME_M)
    assert [branch.attempts for branch in graph.nodes[0].ordered()].count(1) == 1
    assert atlas.mapper.underway is None


def test_a_departure_ends_what_was_under_way_too(cycles: list[Cycle]) -> None:
    """As where the announcements between are not in the recording."""
    events = [event for cycle in cycles for event in cycle.events]
    arrival, departure, next_arrival = (event for event in events if event.node is not None)
    atlas = AtlasServer()
    for event in (arrival, departure, replace(next_arrival, kind=EventKind.DEPARTURE)):
        changed = atlas.step((event,), (), ()).changed
    assert changed
    (link,) = atlas.state.graph.links.values()
    assert (link.from_node, link.to_node) == (0, 1)
