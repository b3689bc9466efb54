"""The simulated robot through the serial line, against the same robot directly."""

import dataclasses
import itertools
import math

import pytest
from hash_seeds import under_two_hash_seeds

from hslam_sim.simulation import Simulation, SimulationConfiguration
from hslam_sim.worlds import load_world
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity
from scout_driver.emulator.config import FaultConfig
from scout_driver.emulator.scout_simulation import ScoutSimulation

WORLD = load_world("small_world", landmark_seed=1)
REST = (8, Velocity())
"""Between two motions, so that the ramps up and down weigh the same whatever their slope."""
PLAN = [
    (40, Velocity(0.25, 0.0)),
    REST,
    (10, Velocity(0.0, 0.6)),
    REST,
    (10, Velocity(0.0, -0.6)),
    REST,
    (30, Velocity(0.2, 0.0)),
]


def _commands() -> list[Velocity]:
    return [command for steps, command in PLAN for _ in range(steps)]


def test_moves_like_the_direct_simulation_to_within_the_units_of_the_line() -> None:
    config = SimulationConfiguration().noise_free()
    line, direct = ScoutSimulation(WORLD, config, seed=1), Simulation(WORLD, config, seed=1)
    for _ in range(4):
        line.step(Velocity())  # setting the base up
    for command in [*_commands(), *[Velocity()] * 10]:
        through, directly = line.step(command), direct.step(command)
    assert math.hypot(through.truth.x - directly.truth.x, through.truth.y - directly.truth.y) < 0.15
    assert abs(wrap(through.truth.theta - directly.truth.theta)) < 0.05
    error = WORLD.start.inverse() @ through.truth
    assert error == pytest.approx(through.odom.base_in_odom, abs=0.005)


def test_every_firing_comes_once_with_the_range_at_its_own_place() -> None:
    config = SimulationConfiguration().noise_free()
    line = ScoutSimulation(WORLD, config, seed=1)
    steps = [line.step(command) for command in _commands()]
    pings = [ping for step in steps for ping in step.sonar.pings]
    stamps = [ping.stamp_ns for ping in pings]
    assert {later - earlier for earlier, later in itertools.pairwise(stamps)} == {60_000_000}
    track = {0: WORLD.start} | {step.stamp_ns: step.truth for step in steps}
    walls = WORLD.free_space.boundary
    # The sonar on the right of a corridor hears its wall: from where the robot was, not from where it is.
    for ping in pings:
        pose = track.get(ping.stamp_ns)
        if pose is not None and ping.sensor == 12 and math.isfinite(ping.range_m):
            x, y = pose.apply(0.0, -(0.19 + ping.range_m))
            assert walls.distance(type(walls.centroid)(x, y)) < 0.06


def steps_of_a_faulty_run() -> str:
    """Return all that a run over a bad line brought."""
    line = ScoutSimulation(WORLD, seed=3, faults=FaultConfig(flipped=0.002, silent=0.02))
    steps = [line.step(command) for command in _commands()]
    fields = [field.name for field in dataclasses.fields(steps[0])]
    return repr([[getattr(step, name) for name in fields] for step in steps])


def test_the_same_seed_gives_the_same_steps_and_faults_do_not_end_the_run() -> None:
    first, second = under_two_hash_seeds(steps_of_a_faulty_run)
    assert first == second
    assert first.count("OdometrySample") == len(_commands())
