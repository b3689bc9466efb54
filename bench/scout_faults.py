"""What each fault of the serial line does to the Scout: `python bench/scout_faults.py [--seconds N] [--seeds N]`.

Driver and emulated base run on a virtual clock.  Somebody commands: forward, a turn, and rests in
between.  For each fault and rate the table says how far the base came compared with a line without
faults, how often a moving base was held, how often the line had to be opened again, how long the
longest way from the last command to rest took, and how far the base went that no command explains.
"""

import argparse
import math
from dataclasses import dataclass

import numpy as np

from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.driver import ScoutDriver
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.faults import Faults
from scout_driver.emulator.floor import EmptyPlane
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.loopback import VirtualClock, opener, wait_until
from scout_driver.units import Wheels

FAULTS = ("flipped", "lost", "doubled", "late", "nak", "silent", "deaf", "short", "repeated", "late_reply", "unplugged")
RATES = (0.001, 0.01, 0.1)
PLAN = ((5.0, Velocity(0.25, 0.0)), (3.0, Velocity(0.0, 0.0)), (3.0, Velocity(0.0, 0.6)), (4.0, None))
"""Duration and command, over and over; None: the commander falls silent."""
PERIOD_S = sum(duration for duration, _ in PLAN)


class Watched(EmptyPlane):
    """A plane that notes how the wheels were turned."""

    def __init__(self) -> None:
        """Start at rest, with nobody having commanded anything."""
        super().__init__()
        self.now_s = self.commanded_s = 0.0
        self.distance_m = self.unexplained_m = self.longest_s = self.fastest_m_s = 0.0
        self.bound_s = math.inf

    def drive(self, wheels: Wheels, duration_s: float) -> None:
        """Move and take notes."""
        super().drive(wheels, duration_s)
        self.now_s += duration_s
        speed = max(map(abs, wheels))
        self.distance_m += speed * duration_s
        self.fastest_m_s = max(self.fastest_m_s, speed)
        if speed > 0.0:
            since_s = self.now_s - self.commanded_s
            self.longest_s = max(self.longest_s, since_s)
            self.unexplained_m += speed * duration_s * (since_s > self.bound_s)


@dataclass(frozen=True)
class Outcome:
    """One run's figures."""

    distance_m: float
    holds: int
    reopened: int
    answered: float
    longest_s: float
    unexplained_m: float
    fastest_m_s: float
    odometry_m: float


def command_at(now_s: float) -> Velocity | None:
    """Return what the commander says at a time."""
    left = now_s % PERIOD_S
    for duration_s, command in PLAN:
        if left < duration_s:
            return command
        left -= duration_s
    return None


def run(faults: FaultConfig, seconds: float, seed: int) -> Outcome:
    """Drive the plan for ``seconds`` of virtual time."""
    config, floor, emulator = DriverConfig(), Watched(), EmulatorConfig()
    # Command time-out, watchdog, and the slowest ramp down; a cycle for each to be noticed in.
    ramp_s = 0.3 / config.wheel_acceleration_m_s2
    floor.bound_s = config.command_timeout_s + config.watchdog_s + ramp_s + 2 * config.cycle_s
    base = EmulatedBase(floor, emulator)
    line = EmulatedLine(base, emulator, Faults(faults, np.random.default_rng(seed)))
    clock = VirtualClock()
    driver = ScoutDriver(config, clock, opener(line, clock))
    driver.enable()
    while clock.now() < seconds:
        started_s = clock.now()
        command = command_at(started_s)
        if command is not None:
            driver.command(command)
            if command != Velocity():
                floor.commanded_s = started_s
        driver.cycle()
        wait_until(line, clock, started_s + config.cycle_s)
    error = math.hypot(
        driver.odometry.base_in_odom.x - floor.true_pose.x, driver.odometry.base_in_odom.y - floor.true_pose.y
    )
    counts = driver.counts
    return Outcome(
        floor.distance_m, driver.guard.stops, driver.line_losses, counts.answered / max(1, counts.exchanges),
        floor.longest_s, floor.unexplained_m, floor.fastest_m_s, error,
    )  # fmt: skip


def main() -> None:
    """Print the matrix."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=150.0)
    parser.add_argument("--seeds", type=int, default=2)
    options = parser.parse_args()
    clean = run(FaultConfig(), options.seconds, 0)
    print("fault        rate   distance  answered  holds  reopened  to rest  unexplained  fastest  odometry error")
    for name, rate in [("none", 0.0), *((name, rate) for name in FAULTS for rate in RATES)]:
        given = FaultConfig() if name == "none" else FaultConfig(**{name: rate})
        all_of = [run(given, options.seconds, seed) for seed in range(options.seeds)]
        mean = [float(np.mean([getattr(o, field) for o in all_of])) for field in ("distance_m", "answered")]
        print(
            f"{name:11s} {100 * rate:5.1f} %  {100 * mean[0] / clean.distance_m:6.1f} %  {100 * mean[1]:6.1f} %"
            f"  {sum(o.holds for o in all_of):5d}  {sum(o.reopened for o in all_of):8d}"
            f"  {max(o.longest_s for o in all_of):5.2f} s  {max(o.unexplained_m for o in all_of):9.3f} m"
            f"  {max(o.fastest_m_s for o in all_of):.3f}  {max(o.odometry_m for o in all_of):8.3f} m"
        )


if __name__ == "__main__":
    main()
