"""One robot in one world, a step at a time: the same object under `sim_node` and in process."""

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from hslam_sim.base_configuration import BaseConfiguration
from hslam_sim.battery import BatteryConfiguration, charge_left, reported_voltage
from hslam_sim.landmark_sensor import LandmarkConfiguration, LandmarkSensor
from hslam_sim.lidar import Lidar
from hslam_sim.lidar_configuration import LidarConfiguration
from hslam_sim.passers_by import Disc, PassersBy, PassersByConfiguration
from hslam_sim.scout_base import ScoutBase
from hslam_sim.sonar import SonarSimulator
from hslam_sim.sonar_configuration import SonarConfiguration
from hslam_sim.wall_index import WallIndex
from hslam_sim.world import World
from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, LandmarkView, OdometrySample, RangeScan, SonarPing, SonarSweep, Velocity


@dataclass(frozen=True)
class ClockConfiguration(Configuration):
    """The rhythm of the simulation."""

    step_s: float = parameter(
        0.12, "time of one step: command in, odometry and pings out (two pings of the Scout)", low=0.01, high=1.0,
        unit="s",
    )  # fmt: skip


@dataclass(frozen=True)
class SimulationConfiguration:
    """Every parameter of the simulated robot, by part."""

    clock: ClockConfiguration = dataclasses.field(default_factory=ClockConfiguration)
    base: BaseConfiguration = dataclasses.field(default_factory=BaseConfiguration)
    sonar: SonarConfiguration = dataclasses.field(default_factory=SonarConfiguration)
    landmarks: LandmarkConfiguration = dataclasses.field(default_factory=LandmarkConfiguration)
    lidar: LidarConfiguration = dataclasses.field(default_factory=LidarConfiguration)
    battery: BatteryConfiguration = dataclasses.field(default_factory=BatteryConfiguration)
    people: PassersByConfiguration = dataclasses.field(default_factory=PassersByConfiguration)

    def noise_free(self) -> Self:
        """Return the same robot with perfect sensors, for tests that ask for it."""
        return dataclasses.replace(
            self,
            base=self.base.noise_free(),
            sonar=self.sonar.noise_free(),
            landmarks=self.landmarks.noise_free(),
            lidar=self.lidar.noise_free(),
        )


class Battery(NamedTuple):
    """The battery at one stamp."""

    voltage_v: float
    charge: float
    """Share of the full charge, 0 to 1."""


@dataclass(frozen=True, slots=True)
class SimStep:
    """Everything one step gives; only the fields up to ``odometer_m`` are for the robot, the rest is for the score."""

    stamp_ns: int
    odom: OdometrySample
    sonar: SonarSweep
    landmarks: LandmarkView | None
    """None on steps without a look."""
    scan: RangeScan | None
    """None without a lidar."""
    bumped: bool
    """Whether a wall stopped the body during the step."""
    battery: Battery
    odometer_m: float
    """Distance the wheels have turned so far, as the encoders tell it."""
    truth: SE2
    """True pose of base_link in map."""
    collisions: int
    """How often the body has met a wall so far."""
    discs: tuple[Disc, ...] = ()
    """People and things that are on no plan."""


class Simulation:
    """A seeded run: the same world, configuration, seed and commands give the same steps, bit for bit.

    Every source of chance has its own generator, so that a change to one sensor leaves the others' draws alone.
    """

    def __init__(self, world: World, config: SimulationConfiguration | None = None, seed: int = 0) -> None:
        """Put the robot at the world's start; time begins at zero."""
        self.config = config = config or SimulationConfiguration()
        world.check_room(config.base.body_radius_m)
        segments = world.walls
        reach = max(SCOUT_RING.range_max_m + SCOUT_RING.mount_radius_m, config.landmarks.range_max_m)
        walls = WallIndex(segments, reach)
        bias, slip, sonar, landmarks, light = (np.random.default_rng([seed, stream]) for stream in range(5))
        self.passers_by = PassersBy(walls, config.people, config.base.body_radius_m, np.random.default_rng([seed, 5]))
        """People, and what a test puts down."""
        self._base = ScoutBase(world.start, walls, config.base, bias, slip)
        self._sonar = SonarSimulator(segments, walls, SCOUT_RING, config.sonar, sonar)
        self._landmarks = LandmarkSensor(world.landmarks, walls, config.landmarks, landmarks)
        self._lidar = Lidar(segments, config.lidar, light) if config.lidar.beams else None
        self._step_ns = round(config.clock.step_s * 1e9)
        self._ping_ns = round(config.sonar.ping_period_s * 1e9)
        self._discs = self.passers_by.discs()
        self._steps = self._pings = 0

    @property
    def stamp_ns(self) -> int:
        """Simulated time now."""
        return self._steps * self._step_ns

    def step(self, command: Velocity | None) -> SimStep:
        """Advance by one step under a command (None: no new one; the base stops when that lasts)."""
        began_ns = self.stamp_ns
        self._base.step(command, self._step_ns * 1e-9)
        self.passers_by.step(self._step_ns * 1e-9, self._base.true_pose)
        self._discs = self.passers_by.discs()
        self._steps += 1
        stamp_ns = self.stamp_ns
        base = self._base
        look = self.config.landmarks.due(self._steps)
        charge = charge_left(self.config.battery, stamp_ns * 1e-9, base.travelled_m)
        return SimStep(
            stamp_ns=stamp_ns,
            odom=OdometrySample(stamp_ns, base.encoder_pose, base.velocity),
            sonar=SonarSweep(stamp_ns, SCOUT_RING, self._fire(began_ns, stamp_ns)),
            landmarks=self._landmarks.look(stamp_ns, base.true_pose) if look else None,
            scan=self._lidar.scan(stamp_ns, base.true_pose, self._discs) if self._lidar is not None else None,
            bumped=base.touching,
            battery=Battery(reported_voltage(self.config.battery, charge), charge),
            odometer_m=base.odometer_m,
            truth=base.true_pose,
            collisions=base.contacts,
            discs=self._discs,
        )

    def _fire(self, began_ns: int, stamp_ns: int) -> tuple[SonarPing, ...]:
        """Fire every ping due after ``began_ns`` and up to ``stamp_ns``, each from where the robot was at its time."""
        pings = []
        while (self._pings + 1) * self._ping_ns <= stamp_ns:
            due_ns = (self._pings + 1) * self._ping_ns
            pose = self._base.true_pose_at((due_ns - began_ns) * 1e-9)
            pings.append(self._sonar.ping(self._pings, due_ns, pose, self._discs))
            self._pings += 1
        return tuple(pings)
