"""What can be asked of the GVG level, and what becomes of a goal that cannot be carried out."""

import math

import pytest

from hslam_gvg.server import GvgError, GvgOutput, GvgServer, GvgState
from hslam_types.gvg_events import EventKind, GoalKind, GvgGoal, NodeKind, NodeView
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, OdometrySample, SonarSweep, Velocity

STEP_NS = 120_000_000


class Robot:
    """A server that stands at a meet point in silence; the test turns it."""

    def __init__(self) -> None:
        self.server = GvgServer()
        self.server._now.node = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, (0.0, 2.0, -2.0))
        self.stamp_ns = 0

    def step(self, heading: float = 0.0) -> GvgOutput:
        """Step once with the robot turned to a heading (rad, odom)."""
        self.stamp_ns += STEP_NS
        odom = OdometrySample(self.stamp_ns, SE2(0.0, 0.0, heading))
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


def test_a_reset_after_a_stop_still_announces_what_the_stop_left_open() -> None:
    robot = Robot()
    for goal in (GvgGoal(GoalKind.TRACE, branch=0), GvgGoal(GoalKind.STOP)):
        robot.server.start(goal)
        robot.step()
    robot.server.reset()
    assert [event.kind for event in robot.step().events] == [EventKind.LOST]


def test_a_reset_at_a_node_forgets_the_node_and_has_nothing_to_announce() -> None:
    robot = Robot()
    robot.step()
    robot.server.reset()
    assert robot.server.node is None
    assert not robot.step().events
