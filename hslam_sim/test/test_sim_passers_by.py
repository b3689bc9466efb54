"""People on the floor: every ranging sensor sees them, they keep off walls and robot, and a run without has none."""

import math

import numpy as np
import pytest
import shapely

from hslam_sim.lidar_configuration import LidarConfiguration
from hslam_sim.passers_by import Disc, PassersByConfiguration
from hslam_sim.simulation import Simulation, SimulationConfiguration
from hslam_sim.worlds import load_world
from hslam_types.sensing import Velocity

WORLD = load_world("small_world")
LIDAR = LidarConfiguration(beams=360)


def crowd(count: int, seed: int = 3) -> Simulation:
    """Return a robot with a lidar and perfect sensors among people."""
    people = PassersByConfiguration(count=count)
    return Simulation(WORLD, SimulationConfiguration(lidar=LIDAR, people=people).noise_free(), seed)


def test_people_keep_off_walls_and_off_the_robot_and_walk() -> None:
    simulation, places = crowd(4), []
    for _ in range(300):
        step = simulation.step(Velocity())
        for x, y, radius in step.discs:
            assert WORLD.free_space.contains_properly(shapely.Point(x, y))
            assert WORLD.clearance(x, y) > radius
            assert math.hypot(x - step.truth.x, y - step.truth.y) > radius + 0.19
            places.append((round(x), round(y)))
    assert len(step.discs) == 4
    assert len(set(places)) > 10


def test_a_scan_ends_at_a_disc_where_it_is_met_and_sonars_hear_it() -> None:
    simulation = crowd(0)
    before = simulation.step(None)
    pose = before.truth
    assert before.scan is not None
    there = pose.apply(0.6, 0.0)
    simulation.passers_by.put(Disc(*there, 0.2))
    steps = [simulation.step(None) for _ in range(8)]
    after = steps[-1]
    assert after.scan is not None
    ahead = int(np.argmin(np.abs(after.scan.bearings)))
    assert after.scan.ranges[ahead] == pytest.approx(0.4, abs=1e-3)
    changed = np.abs(after.scan.ranges - before.scan.ranges) > 1e-9
    assert np.abs(after.scan.bearings[changed]).max() == pytest.approx(math.asin(0.2 / 0.6), abs=0.03)
    front = [ping.range_m for step in steps for ping in step.sonar.pings if ping.sensor == 0]
    assert front
    assert front[-1] == pytest.approx(0.4 - step_mount(), abs=0.03)
    simulation.passers_by.take_away()
    assert simulation.step(None).scan.ranges == pytest.approx(before.scan.ranges)  # type: ignore[union-attr]


def step_mount() -> float:
    """Return how far (m) the sonars sit before the body's centre."""
    return Simulation(WORLD).step(None).sonar.ring.mount_radius_m


def test_a_run_without_people_is_the_run_it_was_and_one_with_them_repeats() -> None:
    alone, crowded, again = (crowd(count) for count in (0, 3, 3))
    for _ in range(50):
        one, two, three = (simulation.step(Velocity(0.2, 0.1)) for simulation in (alone, crowded, again))
        assert one.odom == two.odom == three.odom
        assert len(one.discs) == 0
        assert two.discs == three.discs
