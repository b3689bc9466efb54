"""The simulated robot as the suite sees it through driver and serial line, in one process.

Steps like `hslam_sim`'s `Simulation`, but every command and every reading has been a frame on an
emulated line in between: whole units, sonars of unknown age, counters that overflow and all.
"""

import dataclasses

import numpy as np

from hslam_sim.simulation import Battery, SimStep, SimulationConfiguration
from hslam_sim.world import World
from hslam_types.sensing import Velocity
from scout_driver.clock import BoardTime
from scout_driver.config import DriverConfig
from scout_driver.driver import Reading, ScoutDriver
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.faults import Faults
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.loopback import VirtualClock, opener
from scout_driver.emulator.simulated_floor import SimulatedFloor
from scout_driver.errors import ScoutError
from scout_driver.reading_stamps import ReadingStamps
from scout_driver.units import MOTOR_DIVIDER, volts

NS_PER_MS = 1_000_000
TICK_MS = 30
"""The tick of the direct simulation."""
ATTEMPTS = 100
"""Exchanges tried for one step; only injected faults ever need a second one."""


class ScoutSimulation:
    """A seeded run through the line: the same arguments and commands give the same steps, bit for bit."""

    def __init__(
        self,
        world: World,
        config: SimulationConfiguration | None = None,
        seed: int = 0,
        driver: DriverConfig | None = None,
        faults: FaultConfig | None = None,
    ) -> None:
        """Put the robot at the world's start and open its line; arguments as those of `Simulation`."""
        self.config = config = config or SimulationConfiguration()
        emulator = EmulatorConfig(
            tick_ms=TICK_MS, exchange_s=config.clock.step_s, acceleration_m_s2=config.base.wheel_acceleration
        )
        own = driver or DriverConfig()
        self._floor = SimulatedFloor(world, TICK_MS * 1e-3, seed, config)
        self._base = EmulatedBase(self._floor, emulator)
        self._line = EmulatedLine(self._base, emulator, Faults(faults or FaultConfig(), np.random.default_rng(seed)))
        board, clock = BoardTime(), VirtualClock()
        # One exchange is one step, so that is the driver's cycle.
        own = dataclasses.replace(own, cycle_s=config.clock.step_s)
        self.driver = ScoutDriver(own, board, opener(self._line, clock), board)
        self.driver.enable()
        self._stamps = ReadingStamps(board=True)
        self._steps = 0

    @property
    def stamp_ns(self) -> int:
        """Simulated time now."""
        return self._base.board_ms * NS_PER_MS

    def step(self, command: Velocity | None) -> SimStep:
        """Carry out one exchange under a command (None: no new one). Raises ScoutError if the line stays dead."""
        if command is not None:
            self.driver.command(command)
        reading = self._reading()
        self._steps += 1
        state, floor = reading.state, self._floor
        look = self.config.landmarks.due(self._steps)
        stamp_ns = self._stamps.stamp_ns(reading)
        voltage = volts(state.motor_raw, MOTOR_DIVIDER) if state.motor_raw is not None else floor.volts
        return SimStep(
            stamp_ns=stamp_ns,
            odom=self._stamps.odometry(reading),
            sonar=self._stamps.sweep(reading, reading.pings),
            landmarks=floor.look(stamp_ns) if look else None,
            scan=None,
            bumped=bool(state.bumper),
            battery=Battery(voltage, floor.charge),
            odometer_m=self.driver.odometry.odometer_m,
            truth=floor.true_pose,
            collisions=floor.collisions,
        )

    def _reading(self) -> Reading:
        for _ in range(ATTEMPTS):
            reading = self.driver.cycle()
            if reading is not None:
                return reading
        raise ScoutError(f"the emulated base did not answer {ATTEMPTS} exchanges")
