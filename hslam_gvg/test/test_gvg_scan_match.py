"""A scan is put where it fits the map, as far as odometry may be wrong; announcements stay in odom."""

import dataclasses
import math

import numpy as np
import pytest
from drawn_scans import scan_of
from drawn_walls import CROSSING, Wall
from hypothesis import given, settings
from hypothesis import strategies as st

from hslam_gvg.graph_follower import GraphFollower
from hslam_gvg.ranging.scan_map import ScanMap
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_gvg.ranging.scan_match import Drift, matched, surface
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import OdometrySample, Velocity

ENDS: tuple[Wall, ...] = ((8, -1.2, 8, 1.2), (-8, -1.2, -8, 1.2), (-1.2, 8, 1.2, 8), (-1.2, -8, 1.2, -8))
PLAIN: tuple[Wall, ...] = ((-30, -1.0, 30, -1.0), (30, 1.0, -30, 1.0))
LOOSE = Drift(0.2, 0.2)


def _walls(walls: tuple[Wall, ...], base: SE2) -> Array:
    drawn = ScanMap(ScanMapConfig())
    drawn.hear(scan_of(walls, base), base, 0.0)
    return drawn.obstacle_points()


@settings(max_examples=40, deadline=None)
@given(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-0.03, 0.03))
def test_a_pose_that_odometry_got_wrong_is_put_right(dx: float, dy: float, turn: float) -> None:
    true = SE2(-2.8, 0.1, 0.3)
    walls = _walls(CROSSING + ENDS, SE2(-3.0, 0.1, 0.2))
    wrong = SE2(true.x + dx, true.y + dy, true.theta + turn)
    found = matched(surface(scan_of(CROSSING + ENDS, true), 8.0), wrong, walls, LOOSE, 0.08)
    assert math.hypot(found.x - true.x, found.y - true.y) < 0.02
    assert abs(wrap(found.theta - true.theta)) < 0.005


def test_along_a_plain_corridor_odometry_is_all_there_is() -> None:
    walls = _walls(PLAIN, SE2())
    seen = surface(scan_of(PLAIN, SE2(0.5, 0.0, 0.0)), 8.0)
    found = matched(seen, SE2(0.45, 0.04, 0.02), walls, Drift(0.02, 0.02), 0.08)
    assert found.x == pytest.approx(0.45, abs=0.005)
    assert found.y == pytest.approx(0.0, abs=0.01)
    assert found.theta == pytest.approx(0.0, abs=0.003)


def test_what_fits_nothing_is_left_where_odometry_puts_it() -> None:
    there = SE2(1.0, 2.0, 0.5)
    walls = _walls(PLAIN, SE2())
    assert matched(surface(scan_of(PLAIN, SE2()), 8.0), there, walls + np.array([0.0, 40.0]), LOOSE, 0.08) == there
    assert matched(surface(scan_of(((20, 0, 20, 1),), SE2()), 8.0), there, walls, LOOSE, 0.08) == there
    assert matched(surface(scan_of(PLAIN, SE2()), 8.0), there, np.zeros((0, 2)), LOOSE, 0.08) == there


def test_normals_are_those_of_the_walls_in_base_link_wherever_the_scanner_is_mounted() -> None:
    mounting = SE2(0.1, -0.05, math.radians(30.0))
    for view in (math.tau, math.radians(270.0)):
        seen = surface(scan_of(PLAIN, SE2(), view=view, sensor_in_base=mounting), 8.0)
        assert len(seen.points) > 60
        assert np.abs(seen.points[:, 1]) == pytest.approx(1.0, abs=1e-6)
        assert np.abs(seen.normals[:, 1]) == pytest.approx(1.0, abs=1e-6)


class BentRobot:
    """A base among walls whose odometry bends by so much a metre (rad), with the level that drives it."""

    def __init__(self, bend: float, match_gate_m: float) -> None:
        self.pose, self.odom, self.bend = SE2(-3.0, 0.2, 0.1), SE2(-3.0, 0.2, 0.1), bend
        self.level = GraphFollower(mapping=ScanMapConfig(match_gate_m=match_gate_m))
        self.stamp_ns, self.command = 0, Velocity()

    def until(self, kind: EventKind) -> GvgEvent:
        """Drive until an event of a kind comes; fails when it does not."""
        for _ in range(1500):
            self.stamp_ns += 120_000_000
            way, turn = 0.12 * self.command.forward, 0.12 * self.command.turn
            self.pose = self.pose @ SE2(way, 0.0, turn)
            self.odom = self.odom @ SE2(way, 0.0, turn + self.bend * way)
            scan = dataclasses.replace(scan_of(CROSSING + ENDS, self.pose), stamp_ns=self.stamp_ns)
            out = self.level.step(OdometrySample(self.stamp_ns, self.odom, self.command), scan)
            self.command = out.command
            for event in out.events:
                if event.kind is kind:
                    return event
        pytest.fail(f"no {kind.name}")

    def odom_in_map(self) -> SE2:
        """Return where odom's origin truly is now."""
        return self.pose @ self.odom.inverse()


@pytest.mark.parametrize("bend", [math.radians(2.0), math.radians(-3.0)])
def test_a_node_is_announced_in_the_odometry_of_its_moment_however_bent_the_way_there_was(bend: float) -> None:
    robot = BentRobot(bend, 0.08)
    robot.level.start(GvgGoal(GoalKind.ACCESS))
    for _ in range(3):
        node = robot.until(EventKind.ARRIVAL).node
        assert node is not None
        x, y = robot.odom_in_map().apply(node.x_in_odom, node.y_in_odom)
        at = min(((0.0, 0.0), (6.8, 0.0), (-6.8, 0.0), (0.0, 6.8), (0.0, -6.8)), key=lambda p: math.dist(p, (x, y)))
        assert math.dist(at, (x, y)) < (0.15 if node.degree > 1 else 0.5)
        assert robot.level.node == node
        turn = robot.odom_in_map().theta
        for bearing in node.bearings_in_odom:
            assert abs(math.remainder(bearing + turn, 0.5 * math.pi)) < 0.06
        points = robot.odom_in_map().apply_all(robot.level.obstacle_points())
        near = points[np.hypot(points[:, 0] - robot.pose.x, points[:, 1] - robot.pose.y) < 3.0]
        across = np.minimum(np.abs(np.abs(near[:, 0]) - 1.2), np.abs(np.abs(near[:, 1]) - 1.2))
        ends = np.abs(np.abs(near).max(axis=1) - 8.0)
        assert np.quantile(np.minimum(across, ends), 0.95) < 0.06
        robot.level.start(GvgGoal(GoalKind.TRACE, branch=0))
