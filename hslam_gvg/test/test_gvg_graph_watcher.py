"""The level of a robot that somebody else drives, between drawn walls."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drawn_scans import scan_of
from scanned_robot import CLOSED

from hslam_gvg.graph_watcher import GraphWatcher
from hslam_gvg.level import NONE, level_from_mapping
from hslam_gvg.states import GvgError
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample, Velocity

EAST, NORTH, WEST, SOUTH = 0, 90, 180, 270
START_IN_ODOM = SE2(7.0, -2.0, 2.5)
"""Odometry begins anywhere."""


class Driven:
    """A robot steered along straight lines, and what watches it."""

    def __init__(self, x: float, y: float) -> None:
        self.watcher = GraphWatcher()
        self.pose = self.start = SE2(x, y, 0.0)
        self.stamp_ns = 0
        self.events: list[GvgEvent] = []

    def to(self, x: float, y: float) -> None:
        heading = math.atan2(y - self.pose.y, x - self.pose.x)
        way_m = math.hypot(x - self.pose.x, y - self.pose.y)
        steps = math.ceil(way_m / 0.05)
        for step in range(1, steps + 1):
            share = 0.05 * min(step, way_m / 0.05)
            self.step(SE2(x - (way_m - share) * math.cos(heading), y - (way_m - share) * math.sin(heading), heading))

    def step(self, pose: SE2) -> None:
        self.pose = pose
        self.stamp_ns += 100_000_000
        scan = replace(scan_of(CLOSED, pose), stamp_ns=self.stamp_ns)
        odom = OdometrySample(self.stamp_ns, START_IN_ODOM @ self.start.to(pose), Velocity())
        self.events += self.watcher.step(odom, scan).events

    def told(self) -> list[tuple[str, int, int]]:
        """Return the events: kind, and at nodes the degree and the direction (degrees, to 90) of the branch."""
        found = []
        for event in self.events:
            degree, direction = 0, -1
            if event.node is not None:
                in_world = event.node.bearings_in_odom[event.branch] - START_IN_ODOM.theta + self.start.theta
                degree, direction = event.node.degree, round(math.degrees(in_world) / 90.0) % 4 * 90
            found.append((event.kind.name, degree, direction))
        return found


def test_passing_a_crossing_beside_its_middle_tells_the_meet_point_where_it_is() -> None:
    robot = Driven(-5.0, 0.5)
    robot.to(5.0, 0.5)
    assert robot.told() == [("ACCESS", 0, -1), ("ARRIVAL", 4, WEST), ("DEPARTURE", 4, EAST)]
    node = robot.events[1].node
    assert node is not None
    there = (START_IN_ODOM @ robot.start.inverse()).inverse().apply(node.x_in_odom, node.y_in_odom)
    assert math.hypot(*there) < 0.1
    assert robot.events[1].path_length_m == pytest.approx(5.0, abs=0.5)
    assert [event.sequence for event in robot.events] == [0, 1, 2]


def test_to_a_dead_end_and_back_and_on_by_another_way() -> None:
    robot = Driven(-5.0, 0.0)
    for x, y in ((0.0, 0.0), (0.0, 6.6), (0.3, 0.0), (5.0, -0.3)):
        robot.to(x, y)
    assert robot.told() == [
        ("ACCESS", 0, -1),
        ("ARRIVAL", 4, WEST), ("DEPARTURE", 4, NORTH),
        ("ARRIVAL", 1, SOUTH), ("DEPARTURE", 1, SOUTH),
        ("ARRIVAL", 4, NORTH), ("DEPARTURE", 4, EAST),
    ]  # fmt: skip
    end = robot.events[3]
    assert end.node is not None
    assert end.node.kind is NodeKind.BOUNDARY_POINT
    assert end.path_length_m == pytest.approx(6.5, abs=0.7)
    assert robot.events[5].path_length_m == pytest.approx(6.5, abs=0.7)


def test_who_turns_about_on_an_edge_comes_back_to_the_node_by_the_same_branch() -> None:
    robot = Driven(-5.0, 0.0)
    for x, y in ((0.0, 0.0), (4.0, 0.0), (0.0, 0.0), (0.0, -4.0)):
        robot.to(x, y)
    assert robot.told()[3:] == [("ARRIVAL", 4, EAST), ("DEPARTURE", 4, SOUTH)]
    assert robot.events[3].path_length_m == pytest.approx(8.0, abs=0.5)


def test_a_reset_is_a_loss_and_the_graph_is_reached_anew() -> None:
    robot = Driven(-5.0, 0.0)
    robot.to(4.0, 0.0)
    robot.watcher.reset()
    assert len(robot.watcher.obstacle_points()) == 0
    robot.to(4.5, 0.0)
    assert [event.kind for event in robot.events[-2:]] == [EventKind.LOST, EventKind.ACCESS]
    assert robot.watcher.node is None


def test_nothing_is_commanded_and_no_goal_taken() -> None:
    level, _ = level_from_mapping({"source": "scan", "drive": NONE})
    assert isinstance(level, GraphWatcher)
    assert isinstance(level_from_mapping({"drive": NONE})[0], GraphWatcher)
    for kind in (GoalKind.ACCESS, GoalKind.TRACE, GoalKind.STOP):
        with pytest.raises(GvgError, match="somebody else drives"):
            level.start(GvgGoal(kind))
    out = level.step(OdometrySample(0, SE2(), Velocity()), None)
    assert (out.command, out.events) == (Velocity(), ())
    assert np.isinf(level.room_m)
