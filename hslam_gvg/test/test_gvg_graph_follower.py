"""The level by a scanner, driven through drawn corridors by a base that does as it is told."""

import math

import numpy as np
import pytest
from scanned_robot import ACCESS, CLOSED, STOP, Robot

from hslam_gvg.driving.doing import Idle
from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.states import GvgError, GvgState
from hslam_types.gvg_events import EventKind, GoalKind, GvgGoal, NodeKind
from hslam_types.sensing import Velocity


def test_the_first_node_is_the_crossing_with_its_four_ways() -> None:
    robot = Robot()
    node = robot.arrived()
    assert node.kind is NodeKind.MEET_POINT
    assert math.hypot(node.x_in_odom, node.y_in_odom) < 0.1
    east_first = sorted((bearing + 0.5) % math.tau - 0.5 for bearing in node.bearings_in_odom)
    assert east_first == pytest.approx([0.0, math.pi / 2, math.pi, 1.5 * math.pi], abs=0.05)
    assert list(node.bearings_in_odom) == sorted(node.bearings_in_odom)
    assert node.clearance_m == pytest.approx(1.2 * math.sqrt(2.0), abs=0.05)
    assert robot.level.node == node
    came_by = robot.events[-1].branch
    assert abs(node.bearings_in_odom[came_by]) == pytest.approx(math.pi, abs=0.05)


@pytest.mark.parametrize("branch", [0, 1, 2, 3])
def test_every_way_leads_to_a_dead_end_and_back(branch: int) -> None:
    robot = Robot()
    node = robot.arrived()
    robot.go(GvgGoal(GoalKind.TRACE, branch=branch))
    departure = robot.until(EventKind.DEPARTURE)
    assert departure.branch == branch
    assert abs(math.remainder(robot.pose.theta - node.bearings_in_odom[branch], math.tau)) < 0.1
    end = robot.until(EventKind.ARRIVAL)
    assert end.node is not None
    assert end.node.kind is NodeKind.BOUNDARY_POINT
    # A dead end 2.4 m wide: the graph ends where the corners are as near as the end wall.
    assert math.hypot(end.node.x_in_odom, end.node.y_in_odom) == pytest.approx(6.8, abs=0.4)
    assert 5.0 < end.path_length_m < 7.2
    robot.go(GvgGoal(GoalKind.TRACE, branch=0))
    back = robot.until(EventKind.ARRIVAL)
    assert back.node is not None
    assert back.node.degree == 4
    # Not by number: the way west lies at pi on one visit and at -pi on the next.
    assert abs(math.remainder(back.node.bearings_in_odom[back.branch] - node.bearings_in_odom[branch], math.tau)) < 0.1
    assert robot.room_m > 0.19


def test_whatever_ends_an_edge_is_announced() -> None:
    for ending in (STOP, ACCESS, GvgGoal(GoalKind.STRAIGHT, x_in_odom=0.5, y_in_odom=0.0)):
        robot = Robot()
        robot.arrived()
        robot.go(GvgGoal(GoalKind.TRACE, branch=2))
        robot.until(EventKind.DEPARTURE)
        for _ in range(20):
            robot.step()
        robot.go(ending)
        robot.step()
        assert robot.events[-1].kind is EventKind.LOST, ending
        assert robot.level.path_length_m == 0.0


def test_a_reset_is_announced_and_forgets() -> None:
    robot = Robot()
    robot.arrived()
    robot.go(GvgGoal(GoalKind.TRACE, branch=2))
    robot.until(EventKind.DEPARTURE)
    robot.level.reset()
    assert len(robot.level.obstacle_points()) == 0
    robot.step()
    assert robot.events[-1].kind is EventKind.LOST
    assert robot.state is GvgState.IDLE
    assert robot.command == Velocity()


def test_a_reset_of_a_standing_robot_is_no_loss() -> None:
    robot = Robot()
    robot.step()
    robot.level.reset()
    robot.step()
    assert robot.events == []


def test_goals_that_cannot_be_carried_out_are_refused() -> None:
    robot = Robot()
    robot.step()
    with pytest.raises(GvgError, match="at no node"):
        robot.go(GvgGoal(GoalKind.TRACE, branch=0))
    with pytest.raises(GvgError, match="finite"):
        robot.go(GvgGoal(GoalKind.STRAIGHT))
    robot.arrived()
    with pytest.raises(GvgError, match="no branch 4"):
        robot.go(GvgGoal(GoalKind.TRACE, branch=4))


def test_a_goal_decided_in_a_cycle_begins_in_the_second_after() -> None:
    robot = Robot()
    node = robot.arrived()
    north = node.nearest_branch(robot.pose.theta + 0.5 * math.pi)
    robot.level.start(GvgGoal(GoalKind.TRACE, branch=north), robot.stamp_ns)
    robot.step()
    states = [robot.state]
    robot.step()
    assert [*states, robot.state] == [GvgState.IDLE, GvgState.TURNING]


def test_a_goal_whose_node_was_left_meanwhile_is_dropped_and_named() -> None:
    robot = Robot()
    robot.arrived()
    robot.level.start(GvgGoal(GoalKind.TRACE, branch=2), robot.stamp_ns + 10**12)
    robot.level._driver.begin(Idle())
    robot.level._decided_ns = None
    robot.step()
    assert "at no node" in robot.dropped[0]


def test_a_straight_drive_ends_at_its_point() -> None:
    robot = Robot()
    robot.arrived()
    robot.go(GvgGoal(GoalKind.STRAIGHT, x_in_odom=0.8, y_in_odom=0.5))
    for _ in range(120):
        robot.step()
    assert robot.state is GvgState.IDLE
    assert math.hypot(robot.pose.x - 0.8, robot.pose.y - 0.5) < 0.1
    assert robot.events[-1].kind is EventKind.ARRIVAL  # nothing was lost


def test_a_straight_drive_into_a_wall_is_lost_and_touches_nothing() -> None:
    robot = Robot()
    robot.arrived()
    robot.go(GvgGoal(GoalKind.STRAIGHT, x_in_odom=1.5, y_in_odom=1.5))
    robot.until(EventKind.LOST)
    assert robot.room_m > 0.19


def test_nothing_in_sight_is_lost_after_a_while() -> None:
    robot = Robot(((500.0, 0.0, 501.0, 0.0),), config=FollowConfig(across_m=0.0))
    robot.step()
    robot.go(ACCESS)
    event = robot.until(EventKind.LOST, within_s=60.0)
    assert event.sequence == 0
    assert robot.state is GvgState.IDLE


def test_a_way_shut_in_the_middle_is_an_end() -> None:
    robot = Robot()
    robot.arrived()
    robot.go(GvgGoal(GoalKind.TRACE, branch=2))
    robot.until(EventKind.DEPARTURE)
    for _ in range(10):
        robot.step()
    robot.walls = (*CLOSED, (5.0, -1.2, 5.0, 1.2))
    end = robot.until(EventKind.ARRIVAL)
    assert end.node is not None
    assert end.node.kind is NodeKind.BOUNDARY_POINT
    assert end.node.x_in_odom < 5.0
    assert robot.room_m > 0.19


def test_a_body_held_by_what_nobody_sees_backs_off_and_remembers() -> None:
    robot = Robot()
    robot.arrived()
    robot.go(GvgGoal(GoalKind.TRACE, branch=2))
    robot.until(EventKind.DEPARTURE)
    for _ in range(15):
        robot.step()
    robot.slipping = True
    for _ in range(30):
        robot.step()
        if robot.state is GvgState.RECOILING:
            break
    assert robot.state is GvgState.RECOILING
    assert robot.command.forward < 0.0
    ahead = robot.level.obstacle_points() - np.array([robot.pose.x, robot.pose.y])
    assert np.hypot(ahead[:, 0], ahead[:, 1]).min() == pytest.approx(0.21, abs=0.03)


def test_without_scans_it_stands_and_with_the_next_goes_on() -> None:
    robot = Robot()
    robot.arrived()
    robot.go(GvgGoal(GoalKind.TRACE, branch=2))
    robot.until(EventKind.DEPARTURE)
    for _ in range(10):
        robot.step(blind=True)
    stood = robot.pose
    for _ in range(200):
        robot.step(blind=True)
    assert robot.pose == stood
    assert robot.room_m > 0.19
    robot.until(EventKind.ARRIVAL)


def test_the_clearance_of_where_it_is_is_told() -> None:
    robot = Robot()
    robot.arrived()
    assert robot.level.room_m == pytest.approx(1.2 * math.sqrt(2.0), abs=0.1)
    assert robot.level.distance_left_m == 0.0
