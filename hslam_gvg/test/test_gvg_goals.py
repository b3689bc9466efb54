"""What can be asked of the GVG level, and what becomes of a goal that cannot be carried out."""

import math
from contextlib import suppress
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hslam_gvg.server import GvgError, GvgOutput, GvgServer, GvgState
from hslam_gvg.stall import STALL_S
from hslam_gvg.states import ON_EDGE
from hslam_types.gvg_events import EventKind, GoalKind, GvgGoal, NodeKind, NodeView
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, OdometrySample, SonarSweep, Velocity

STEP_NS = 120_000_000
STEP_S = STEP_NS * 1e-9


NODE = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, (0.0, 2.0, -2.0))


class Robot:
    """A server that stands at a meet point in silence; the test turns it."""

    def __init__(self) -> None:
        self.server = GvgServer()
        self.server._now.node = NODE
        self.stamp_ns = 0

    def step(self, heading: float = 0.0, x: float = 0.0) -> GvgOutput:
        """Step once with the robot at x (m, odom) and turned to a heading (rad, odom)."""
        self.stamp_ns += STEP_NS
        odom = OdometrySample(self.stamp_ns, SE2(x, 0.0, heading))
        return self.server.step(odom, SonarSweep(self.stamp_ns, SCOUT_RING, ()))


@pytest.mark.parametrize("target", [(math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, -math.inf)])
def test_a_target_that_is_no_point_is_refused(target: tuple[float, float]) -> None:
    server = GvgServer()
    with pytest.raises(GvgError, match="finite"):
        server.start(GvgGoal(GoalKind.STRAIGHT, x_in_odom=target[0], y_in_odom=target[1]))
    assert server.next_goal is None


def test_a_goal_overtaken_by_the_departure_is_dropped_and_the_traversal_goes_on() -> None:
    robot = Robot()
    robot.server.start(GvgGoal(GoalKind.TRACE, branch=0))
    assert robot.step(heading=1.0).state is GvgState.TURNING
    robot.server.start(GvgGoal(GoalKind.TRACE, branch=1), decided_ns=robot.stamp_ns)
    departed = robot.step()
    assert [(event.kind, event.branch) for event in departed.events] == [(EventKind.DEPARTURE, 0)]
    assert not departed.dropped
    after = robot.step()
    assert "at no node" in after.dropped
    assert (after.state, after.events, robot.server.next_goal) == (GvgState.TRACING, (), None)
    assert not robot.step().dropped


def test_a_reset_on_the_way_is_announced_and_the_count_of_events_goes_on() -> None:
    robot = Robot()
    robot.server.start(GvgGoal(GoalKind.TRACE, branch=0))
    (departure,) = robot.step().events
    robot.server.reset()
    robot.server.start(GvgGoal(GoalKind.ACCESS))
    out = robot.step()
    assert [(event.kind, event.sequence) for event in out.events] == [(EventKind.LOST, departure.sequence + 1)]
    assert out.events[0].stamp_ns == robot.stamp_ns
    assert (out.state, out.command) == (GvgState.IDLE, Velocity())
    # What was asked since is not ended by that.
    assert robot.step().state is GvgState.LISTENING


STRAIGHT = GvgGoal(GoalKind.STRAIGHT, x_in_odom=2.0, y_in_odom=0.0)
TAKEOVERS = {
    GvgGoal(GoalKind.STOP): GvgState.IDLE,
    GvgGoal(GoalKind.ACCESS): GvgState.LISTENING,
    STRAIGHT: GvgState.STRAIGHT,
}
"""What can take the place of a traversal, and the state that it leads to."""


@pytest.mark.parametrize("goal", TAKEOVERS, ids=lambda goal: goal.kind.name)
def test_a_goal_in_the_middle_of_an_edge_ends_the_traversal_with_a_word(goal: GvgGoal) -> None:
    robot = Robot()
    robot.server.start(GvgGoal(GoalKind.TRACE, branch=0))
    (departure,) = robot.step().events
    assert robot.step().state is GvgState.TRACING
    robot.server.start(goal)
    out = robot.step()
    assert [(e.kind, e.sequence, e.stamp_ns) for e in out.events] == [
        (EventKind.LOST, departure.sequence + 1, robot.stamp_ns)
    ]
    assert (out.state, out.command, robot.server.path_length_m) == (GvgState.IDLE, Velocity(), 0.0)
    # The end is told before the new goal begins, so that nobody takes it for that goal's.
    assert robot.server.next_goal == goal
    begun = robot.step()
    assert (begun.state, begun.events) == (TAKEOVERS[goal], ())


@pytest.mark.parametrize("held_for", range(1, math.ceil(STALL_S / STEP_S)))
def test_a_goal_in_the_middle_of_an_edge_does_not_answer_for_a_body_held_before_it(held_for: int) -> None:
    robot = Robot()
    robot.server.start(GvgGoal(GoalKind.TRACE, branch=0))
    for x in (0.0, 0.1, 0.2, 0.3, 0.4, *(0.4,) * held_for):
        assert robot.step(x=x).state is GvgState.TRACING
    robot.server.start(GvgGoal(GoalKind.STOP))
    assert [robot.step(x=0.4).state for _ in range(2)] == [GvgState.IDLE, GvgState.IDLE]


@pytest.mark.parametrize("goal", TAKEOVERS, ids=lambda goal: goal.kind.name)
def test_a_goal_before_the_departure_has_nothing_to_end(goal: GvgGoal) -> None:
    robot = Robot()
    robot.server.start(GvgGoal(GoalKind.TRACE, branch=0))
    assert robot.step(heading=1.0).state is GvgState.TURNING
    robot.server.start(goal)
    out = robot.step()
    assert (out.state, out.events) == (TAKEOVERS[goal], ())


def test_a_traversal_that_a_stop_has_ended_is_not_ended_again_by_a_reset() -> None:
    robot = Robot()
    for goal in (GvgGoal(GoalKind.TRACE, branch=0), GvgGoal(GoalKind.STOP)):
        robot.server.start(goal)
        robot.step()
    robot.step()
    robot.server.reset()
    assert not robot.step().events


def test_two_resets_in_one_cycle_end_a_traversal_once() -> None:
    robot = Robot()
    robot.server.start(GvgGoal(GoalKind.TRACE, branch=0))
    robot.step()
    for _ in range(2):
        robot.server.reset()
        robot.server.start(GvgGoal(GoalKind.ACCESS))
    assert [event.kind for event in robot.step().events] == [EventKind.LOST]


class Happening(NamedTuple):
    """What is asked of the level (`None`: a reset), and where the base is in the steps after."""

    goal: GvgGoal | None
    x: float
    heading: float
    steps: int


GOALS = st.sampled_from([None, *TAKEOVERS, GvgGoal(GoalKind.TRACE, branch=0), GvgGoal(GoalKind.TRACE, branch=1)])
BEGINS = (EventKind.ACCESS, EventKind.DEPARTURE)


HAPPENINGS = st.builds(
    Happening, GOALS, st.floats(-0.5, 0.5), st.sampled_from([0.0, 2.0, 3.0]), st.sampled_from([1, 2, 5, 60])
)


@settings(max_examples=40)
@given(st.lists(HAPPENINGS, max_size=8))
def test_every_traversal_has_one_beginning_and_one_end(happenings: list[Happening]) -> None:
    """Whatever is asked when: none begins while another is under way, and none outlasts the states of an edge."""
    robot, traversing, sequence = Robot(), False, 0
    for goal, x, heading, steps in happenings:
        if goal is None:
            robot.server.reset()
            robot.server._now.node = NODE
        else:
            with suppress(GvgError):
                robot.server.start(goal)
        for _ in range(steps):
            out = robot.step(heading, x)
            for event in out.events:
                assert event.sequence == sequence
                assert not (traversing and event.kind in BEGINS)
                traversing, sequence = event.kind in BEGINS, sequence + 1
            # Only the way back from what held the body is driven off the edge too.
            assert traversing or out.state not in ON_EDGE - {GvgState.RECOILING}
            assert out.state in ON_EDGE or not traversing


def test_a_reset_at_a_node_forgets_the_node_and_has_nothing_to_announce() -> None:
    robot = Robot()
    robot.step()
    robot.server.reset()
    assert robot.server.node is None
    assert not robot.step().events
