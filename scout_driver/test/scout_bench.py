"""A driver and an emulated base on one virtual clock: what the tests of both begin with."""

from dataclasses import dataclass, field

import numpy as np

from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.driver import Reading, ScoutDriver
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.faults import Faults
from scout_driver.emulator.floor import EmptyPlane
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.loopback import VirtualClock, opener, wait_until
from scout_driver.protocol.commands import CommandKind

FORWARD = Velocity(0.25, 0.0)
STOPPING_M = 0.25**2 / (2 * 0.9) + 0.01
"""Way from 0.25 m/s to rest at the acceleration the driver gives the base, and the ticks."""


class Wall(EmptyPlane):
    """A plane with a wall across x = 1 m, met by the body without any radius."""

    def range_m(self, sensor: int) -> float:
        """Hear the wall straight ahead, wherever the sensor looks."""
        del sensor
        return max(0.2, 1.0 - self.true_pose.x)

    @property
    def bumped(self) -> bool:
        """Whether the wall is met."""
        return self.true_pose.x >= 1.0 and sum(self.wheels) > 0.01


@dataclass
class Bench:
    """One driver, one base, one clock."""

    config: DriverConfig = field(default_factory=DriverConfig)
    emulator: EmulatorConfig = field(default_factory=EmulatorConfig)
    faults: FaultConfig = field(default_factory=FaultConfig)
    floor: EmptyPlane = field(default_factory=EmptyPlane)
    seed: int = 0

    def __post_init__(self) -> None:
        """Connect everything."""
        self.base = EmulatedBase(self.floor, self.emulator)
        self.line = EmulatedLine(self.base, self.emulator, Faults(self.faults, np.random.default_rng(self.seed)))
        self.clock = VirtualClock()
        self.driver = ScoutDriver(self.config, self.clock, opener(self.line, self.clock))
        self.driver.enable()

    def run(self, duration_s: float, command: Velocity | None) -> list[Reading]:
        """Cycle for a time, with a command each cycle (None: nobody commands)."""
        readings, end_s = [], self.clock.now() + duration_s
        while self.clock.now() < end_s:
            started_s = self.clock.now()
            if command is not None:
                self.driver.command(command)
            if (reading := self.driver.cycle()) is not None:
                readings.append(reading)
            wait_until(self.line, self.clock, started_s + self.config.cycle_s)
        return readings

    def silence(self, *, deaf: bool) -> None:
        """Let the base hear nothing and say nothing from now on, or hear and answer again."""
        self.line._faults = Faults(FaultConfig(deaf=float(deaf)), np.random.default_rng(0))

    @property
    def wheel_commands(self) -> list[tuple[int, int]]:
        """The velocities (first and second axis, 0.1 in/s) that have reached the base."""
        return [(c.values[0], c.values[1]) for _, c in self.line.commands if c.kind is CommandKind.VELOCITY]

    @property
    def speed(self) -> float:
        """Fastest true wheel now (m/s)."""
        return max(map(abs, self.floor.wheels))
