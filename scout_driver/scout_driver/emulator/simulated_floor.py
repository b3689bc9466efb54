"""A world of `hslam_sim` under the emulated base: the same slip, drift, walls and sonar as the direct simulation."""

import dataclasses
import math

import numpy as np

from hslam_sim.battery import charge_left, reported_voltage
from hslam_sim.landmark_sensor import LandmarkSensor
from hslam_sim.scout_base import ScoutBase
from hslam_sim.simulation import SimulationConfiguration
from hslam_sim.sonar import SCOUT_FIRING_ORDER, SonarSimulator
from hslam_sim.wall_index import WallIndex
from hslam_sim.world import World
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, LandmarkView, SonarPing
from scout_driver.units import Wheels, velocity_from_wheels, wheels_from_velocity

INSTANT = 20.0
"""The emulated base ramps its wheels by itself (AC); the simulated one below it must not do so again (m/s^2)."""


class SimulatedFloor:
    """A seeded robot in a world, moved in short ticks.

    The simulation draws its slip once a step; ticks are shorter, so the draws are made larger by the
    root of the ratio: what adds up over a metre has the same variance.
    """

    def __init__(
        self, world: World, tick_s: float, seed: int = 0, config: SimulationConfiguration | None = None
    ) -> None:
        """Put the robot at the world's start; the streams of chance are those of `hslam_sim`."""
        self._config = config = config or SimulationConfiguration()
        more = math.sqrt(config.clock.step_s / tick_s)
        base = dataclasses.replace(
            config.base,
            wheel_acceleration=INSTANT,
            slip_fraction=min(0.5, config.base.slip_fraction * more),
            turn_slip_fraction=min(0.5, config.base.turn_slip_fraction * more),
        )
        self._wheel_base_m = base.wheel_base_m
        reach = max(SCOUT_RING.range_max_m + SCOUT_RING.mount_radius_m, config.landmarks.range_max_m)
        walls = WallIndex(world.walls, reach)
        bias, slip, sonar, landmarks = (np.random.default_rng([seed, stream]) for stream in range(4))
        self._base = ScoutBase(world.start, walls, base, bias, slip)
        self._sonar = SonarSimulator(world.walls, walls, SCOUT_RING, config.sonar, sonar)
        self._landmarks = LandmarkSensor(world.landmarks, walls, config.landmarks, landmarks)
        self._rank = {sensor: rank for rank, sensor in enumerate(SCOUT_FIRING_ORDER)}
        self._elapsed_s = 0.0

    @property
    def encoder_pose(self) -> SE2:
        """The pose the encoders tell."""
        return self._base.encoder_pose

    @encoder_pose.setter
    def encoder_pose(self, pose: SE2) -> None:
        self._base.encoder_pose = pose

    @property
    def true_pose(self) -> SE2:
        """The pose of base_link in map."""
        return self._base.true_pose

    @property
    def wheels(self) -> Wheels:
        """The wheel speeds the encoders tell."""
        return wheels_from_velocity(self._base.velocity, self._wheel_base_m)

    @property
    def bumped(self) -> bool:
        """Whether a wall held the body in the last tick."""
        return self._base.touching

    @property
    def collisions(self) -> int:
        """How often the body has met a wall."""
        return self._base.contacts

    @property
    def travelled_m(self) -> float:
        """True distance driven."""
        return self._base.travelled_m

    @property
    def charge(self) -> float:
        """Share of the battery's charge that is left, 0 to 1."""
        return charge_left(self._config.battery, self._elapsed_s, self._base.travelled_m)

    @property
    def volts(self) -> float:
        """Battery voltage."""
        return reported_voltage(self._config.battery, self.charge)

    def drive(self, wheels: Wheels, duration_s: float) -> None:
        """Move for one tick."""
        self._elapsed_s += duration_s
        self._base.step(velocity_from_wheels(wheels, self._wheel_base_m), duration_s)

    def range_m(self, sensor: int) -> float:
        """Fire one sonar from where the robot is."""
        ping: SonarPing = self._sonar.ping(self._rank[sensor], 0, self._base.true_pose)
        return ping.range_m

    def look(self, stamp_ns: int) -> LandmarkView:
        """Look for landmarks from where the robot is."""
        return self._landmarks.look(stamp_ns, self._base.true_pose)
