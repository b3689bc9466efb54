"""Edge-maps of a robot that follows the GVG by sonar in the hard simulator, against the true landmarks.

Odometry with slip and bias, occlusion, missed and false sightings, backing up and probing: what the filter's own
synthetic drives do not have.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from hslam_ekf.server import EkfServer
from hslam_gvg.server import GvgServer
from hslam_sim.simulation import SimStep, Simulation
from hslam_sim.worlds import load_world
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.se2 import SE2, Array, wrap

TRAVERSALS = 4
SAME_M = 0.5
"""A mapped landmark this near to a true one is that one; boxes are at least 0.6 m apart."""


@dataclass(frozen=True)
class Scored:
    """One edge-map beside the truth."""

    edge_map: EdgeMap
    errors: Array
    """Terminal x, then x and y of each mapped landmark (m)."""
    nearest: Array
    """Index of the true landmark of each mapped one."""
    distance: Array
    """Distance to it (m)."""


@dataclass(frozen=True)
class Run:
    """What a drive gave."""

    maps: list[Scored]
    links: list[float]
    """Squared normalised error of each link (3 degrees of freedom)."""


def node_in_map(step: SimStep, event: GvgEvent) -> tuple[float, float]:
    """Return where the node of an event truly is, given where the robot truly is."""
    assert event.node is not None
    odom_in_map = step.truth @ step.odom.base_in_odom.inverse()
    return odom_in_map.apply(event.node.x_in_odom, event.node.y_in_odom)


def scored(edge_map: EdgeMap, edge: SE2, length_m: float, landmarks: Array) -> Scored:
    """Compare an edge-map with the true landmarks, in the true edge frame."""
    true = edge.inverse().apply_all(landmarks)
    gaps = np.linalg.norm(edge_map.landmarks[:, None] - true[None], axis=2)
    nearest = gaps.argmin(axis=1)
    errors = np.concatenate(([edge_map.terminal_x - length_m], (edge_map.landmarks - true[nearest]).ravel()))
    return Scored(edge_map, errors, nearest, gaps.min(axis=1))


@pytest.fixture(scope="module")
def run() -> Run:
    """Drive along the first edges of the small world, always on by the next branch."""
    world = load_world("small_world")
    simulation, gvg, ekf = Simulation(world, seed=3), GvgServer(), EkfServer()
    gvg.start(GvgGoal(GoalKind.ACCESS))
    step, maps, links = simulation.step(None), list[Scored](), list[float]()
    start, edge = SE2(), SE2()
    while len(maps) < TRAVERSALS or not links:
        driven = gvg.step(step.odom, step.sonar)
        out = ekf.step(step.odom, step.landmarks, driven.events)
        for event in driven.events:
            if event.kind is EventKind.ACCESS:
                continue
            assert event.node is not None, "the robot lost the GVG"
            x, y = node_in_map(step, event)
            if event.kind is EventKind.DEPARTURE:
                turn = wrap(step.truth.theta - step.odom.base_in_odom.theta)
                start = SE2(x, y, wrap(event.node.bearings_in_odom[event.branch] + turn))
                for link in out.links:
                    error = np.array(link.departure_in_edge) - np.array(edge.to(start))
                    error[2] = wrap(float(error[2]))
                    links.append(float(error @ np.linalg.solve(link.covariance, error)))
            else:
                edge = SE2(start.x, start.y, math.atan2(y - start.y, x - start.x))
                length_m = math.hypot(x - start.x, y - start.y)
                maps += [scored(edge_map, edge, length_m, world.landmarks) for edge_map in out.edge_maps]
                gvg.start(GvgGoal(GoalKind.TRACE, (event.branch + 1) % event.node.degree))
        assert step.stamp_ns < 900e9, "too few arrivals"
        step = simulation.step(driven.command)
    return Run(maps, links)


def test_no_false_and_no_double_landmark(run: Run) -> None:
    for one in run.maps:
        assert one.distance.max() < SAME_M
        assert len(set(one.nearest.tolist())) == one.edge_map.size


def test_landmarks_are_where_they_are(run: Run) -> None:
    for one in run.maps:
        assert one.edge_map.size >= 10
        assert float(np.sqrt(np.mean(one.distance**2))) < 0.12


def test_the_maps_are_as_sure_as_they_may_be(run: Run) -> None:
    """NEES by dimension: near one; the errors of a map are strongly correlated, so the bounds are wide."""
    total, freedom = 0.0, 0
    for one in run.maps:
        rows = [0, *range(2, 2 + 2 * one.edge_map.size)]
        covariance = one.edge_map.covariance[np.ix_(rows, rows)]
        total += float(one.errors @ np.linalg.solve(covariance, one.errors))
        freedom += len(rows)
    assert 0.7 < total / freedom < 1.5


def test_links_are_as_sure_as_they_may_be(run: Run) -> None:
    assert np.mean(run.links) / 3.0 < 2.5
