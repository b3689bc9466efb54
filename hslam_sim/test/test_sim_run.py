"""A whole simulated run: repeatable, with independent streams of chance and readings taken when they say."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
import shapely

from hslam_sim.battery import BatteryConfiguration, charge_left, reported_voltage
from hslam_sim.simulation import SimStep, Simulation, SimulationConfiguration
from hslam_sim.world import World
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, Velocity

BOXES = np.array([[2.0, 0.0], [5.0, 3.0], [9.0, 0.0], [0.0, 1.0], [10.0, 2.0]])
ROOM = World("room", shapely.box(0, 0, 10, 3), SE2(1.0, 1.5, 0.0), BOXES)


def drive(config: SimulationConfiguration, seed: int, steps: int = 150) -> list[SimStep]:
    """Return the steps of a fixed drive that also meets a wall."""
    simulation = Simulation(ROOM, config, seed)
    return [simulation.step(Velocity(0.5, 0.3 * math.sin(0.1 * i))) for i in range(steps)]


def test_one_seed_gives_one_run_and_another_seed_another() -> None:
    """Every field of every step is equal, bit for bit, for equal seeds only."""
    config = SimulationConfiguration()
    first, again, other = drive(config, 1), drive(config, 1), drive(config, 2)
    assert first == again
    assert first != other
    assert first[-1].collisions > 0


def test_each_sensor_has_its_own_stream() -> None:
    """A change to one part leaves the draws of the others alone."""
    config = SimulationConfiguration()
    usual = drive(config, 1)
    deaf = drive(dataclasses.replace(config, sonar=config.sonar.noise_free()), 1)
    sharp = drive(dataclasses.replace(config, landmarks=config.landmarks.noise_free()), 1)
    assert [(s.truth, s.odom, s.landmarks) for s in usual] == [(s.truth, s.odom, s.landmarks) for s in deaf]
    assert [(s.truth, s.odom, s.sonar) for s in usual] == [(s.truth, s.odom, s.sonar) for s in sharp]
    assert [s.sonar for s in usual] != [s.sonar for s in deaf]
    assert [s.landmarks for s in usual] != [s.landmarks for s in sharp]


@pytest.mark.parametrize("step_s", [0.12, 0.1, 0.25])
def test_every_ping_is_fired_once_at_its_time(step_s: float) -> None:
    """Whatever the step, pings come every 60 ms, each in the sweep of the step that contains it."""
    config = SimulationConfiguration()
    config = dataclasses.replace(config, clock=dataclasses.replace(config.clock, step_s=step_s))
    steps = drive(config, 1, 60)
    stamps = [ping.stamp_ns for step in steps for ping in step.sonar.pings]
    assert stamps == [60_000_000 * (k + 1) for k in range(len(stamps))]
    assert stamps[-1] > steps[-1].stamp_ns - 60_000_000
    for before, step in itertools.pairwise(steps):
        assert all(before.stamp_ns < ping.stamp_ns <= step.stamp_ns for ping in step.sonar.pings)
        assert step.odom.stamp_ns == step.sonar.stamp_ns == step.stamp_ns


def test_a_ping_hears_from_where_the_robot_was() -> None:
    """Driving at a wall without noise, each forward reading is the distance at the ping's own time."""
    config = SimulationConfiguration().noise_free()
    simulation = Simulation(World("long", shapely.box(0, 0, 10, 30), SE2(5, 20, math.pi / 2), BOXES), config)
    for _ in range(60):
        simulation.step(Velocity(0.5, 0.0))
    checked = 0
    for _ in range(40):
        step = simulation.step(Velocity(0.5, 0.0))
        for ping in step.sonar.pings:
            y_then = step.truth.y - 0.5 * (step.stamp_ns - ping.stamp_ns) * 1e-9
            if ping.sensor == 0 and ping.range_m < math.inf:
                assert ping.range_m == pytest.approx(30 - y_then - SCOUT_RING.mount_radius_m, abs=1e-3)
                checked += 1
    assert checked >= 4


def test_looks_come_every_third_step() -> None:
    """Other steps carry no view at all, which is not an empty one."""
    steps = drive(SimulationConfiguration(), 1, 9)
    assert [step.landmarks is not None for step in steps] == [False, False, True] * 3


def test_the_battery_runs_down_in_the_board_s_steps() -> None:
    """Time and distance both cost charge, which never falls below nothing."""
    config = BatteryConfiguration()
    assert charge_left(config, 0.0, 0.0) == 1.0
    assert charge_left(config, 3600.0, 0.0) > charge_left(config, 3600.0, 500.0) > 0.0
    assert charge_left(config, 1e6, 0.0) == 0.0
    levels = {reported_voltage(config, c) for c in np.linspace(0.0, 1.0, 500).tolist()}
    assert len(levels) < 70
    assert min(levels) == pytest.approx(config.empty_v, abs=0.02)
    assert max(levels) == pytest.approx(config.full_v, abs=0.02)
