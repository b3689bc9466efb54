"""Halls wider than the scanner reaches: their open middle is an obstacle, and the robot gets to their walls."""

import math

import numpy as np
import pytest
from drawn_scans import scan_of
from drawn_walls import Wall
from scanned_robot import Robot

from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.local_graph.local_graph import local_graph
from hslam_gvg.ranging.rolling_grid import RollingGrid
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_gvg.ranging.scanned_map import ScannedMap
from hslam_gvg.states import GvgState
from hslam_types.gvg_events import EventKind, GoalKind, GvgGoal
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample, Velocity

HALL: tuple[Wall, ...] = ((0, 0, 40, 0), (40, 0, 40, 30), (40, 30, 0, 30), (0, 30, 0, 0))
BY_WALL = SE2(2.6, 15.0, 0.5 * math.pi)


def seen_from(pose: SE2) -> ScannedMap:
    """Return the map after one scan of the hall."""
    seen = ScannedMap(FollowConfig(), ScanMapConfig())
    seen.hear(scan_of(HALL, pose), OdometrySample(0, pose, Velocity()), 0.0, attentive=True)
    return seen


def test_a_cell_is_open_if_it_is_free_and_far_from_what_is_known() -> None:
    grid = RollingGrid(0.1, 4.0)
    grid.free_inside(np.array([[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]]), 0.0)
    grid.occupy(np.column_stack((np.full(60, -2.95), np.arange(-2.95, 3.0, 0.1))), 0.0)
    far = grid.free_and_far(2.0)
    x = np.array([-1.15, -0.75, 2.9, 3.2])
    assert grid.contains(far, x, np.zeros(4)).tolist() == [False, True, True, False]
    outline = grid.outline(far)
    assert outline[:, 0].min() == pytest.approx(-0.85, abs=0.11)
    assert np.abs(outline).max() == pytest.approx(3.0, abs=0.06)
    # Each of its points has two neighbours: no way leads through it.
    apart = np.hypot(*(outline[:, None] - outline[None]).transpose(2, 0, 1))
    assert ((apart < 0.15).sum(axis=1) >= 3).all()


def test_where_nothing_is_known_to_stand_all_that_is_free_is_open() -> None:
    grid = RollingGrid(0.1, 2.0)
    grid.free_inside(np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), 0.0)
    assert grid.contains(grid.free_and_far(5.0), np.zeros(1), np.zeros(1)).all()


def test_open_space_begins_at_the_distance_of_the_truth() -> None:
    space = seen_from(BY_WALL).open_space()
    x = np.array([4.8, 5.2, 8.0])
    assert space.holds(x, np.full(3, 15.0)).tolist() == [False, True, True]
    assert space.outline[:, 0].min() == pytest.approx(5.0, abs=0.08)


def test_a_short_sighted_scanner_sees_the_wall_and_the_open_before_it() -> None:
    mapping = ScanMapConfig(reach_m=4.0)
    seen = ScannedMap(FollowConfig(), mapping)
    seen.hear(scan_of(HALL, BY_WALL, reach_m=4.0), OdometrySample(0, BY_WALL, Velocity()), 0.0, attentive=True)
    x = np.array([2.2, 2.7, 4.0])
    assert seen.open_space().holds(x, np.full(3, 15.0)).tolist() == [False, True, True]


def test_the_graph_of_a_wide_hall_lies_half_way_between_wall_and_open_space() -> None:
    seen = seen_from(BY_WALL)
    points = seen.obstacle_points()
    assert local_graph(points, seen.is_free, BY_WALL.x, BY_WALL.y, LocalGraphConfig()) is None
    graph = local_graph(points, seen.is_free, BY_WALL.x, BY_WALL.y, LocalGraphConfig(), open_space=seen.open_space())
    assert graph is not None
    path = np.vstack([path for _, path in graph.paths()])
    near = path[np.abs(path[:, 1] - 15.0) < 3.0]
    assert len(near) > 20
    assert near[:, 0] == pytest.approx(2.5, abs=0.1)
    assert not graph.nodes()


def test_from_the_open_middle_the_robot_gets_to_a_wall_and_follows_it() -> None:
    robot = Robot(HALL, SE2(18.0, 15.0, 0.1))
    robot.level.start(GvgGoal(GoalKind.ACCESS))
    robot.until(EventKind.ACCESS)
    for _ in range(200):
        robot.step()
    assert robot.state is GvgState.TRACING
    assert min(40.0 - robot.pose.x, 30.0 - robot.pose.y, robot.pose.y) == pytest.approx(2.5, abs=0.4)
    assert robot.room_m > 2.0


@pytest.mark.parametrize("way", [0.5 * math.pi, -0.5 * math.pi])
def test_it_crosses_the_open_in_the_direction_asked_for(way: float) -> None:
    robot = Robot(HALL, SE2(18.0, 15.0, 0.1))
    robot.level.start(GvgGoal(GoalKind.ACCESS, heading_in_odom=way))
    robot.until(EventKind.ACCESS)
    assert (robot.pose.y - 15.0) * way > 3.0
    assert robot.pose.x == pytest.approx(18.0, abs=0.5)


def test_a_crossing_that_leads_nowhere_is_given_up() -> None:
    nothing: tuple[Wall, ...] = ((500, 0, 500, 1),)
    robot = Robot(nothing, SE2(0.0, 0.0, 0.0), FollowConfig(across_m=5.0, access_s=4.0))
    robot.level.start(GvgGoal(GoalKind.ACCESS))
    robot.until(EventKind.LOST)
    assert 4.8 < robot.pose.x < 5.4
