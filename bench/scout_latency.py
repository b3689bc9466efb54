"""From a sonar's echo to the wheels, and what the driver costs: `python bench/scout_latency.py [--seconds N]`.

The driver's node runs as a process of its own and speaks over a pseudo-terminal to an emulated base
whose sonars hear something new at every firing.  A node answers each reading at once with a speed of
its own; the figure is the time from the echo at the base to the base having understood that speed.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from pathlib import Path

import numpy as np
import psutil
import rclpy
from geometry_msgs.msg import TwistStamped
from hslam_msgs.msg import SonarRing
from rclpy.executors import Executor

from hslam_bringup.linear_algebra import ON_ONE_THREAD
from hslam_ros.conversions import sonar_from_msg, velocity_to_msg
from hslam_ros.executor import make_executor
from hslam_ros.private_domain import private_domain
from hslam_ros.qos import SENSOR
from hslam_types.sensing import Velocity
from scout_driver.clock import WallClock
from scout_driver.config import DriverConfig
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.faults import Faults
from scout_driver.emulator.floor import EmptyPlane
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.ports import PtyPort
from scout_driver.emulator.server import EmulatorServer
from scout_driver.protocol.commands import CommandKind
from scout_driver.units import METRES_PER_INCH, METRES_PER_UNIT

SOUND_M_S = 343.0
SUPERSEDED_S = 1.0
"""An answer not understood for so long was overtaken by the next one before it was sent."""
SPEEDS = range(20, 60)
"""Speeds answered with, in wire units, one after the other."""


class Surprises(EmptyPlane):
    """A floor on which every firing hears another distance; notes when each echo came back."""

    def __init__(self, clock: WallClock) -> None:
        """Hear by the clock of the emulation."""
        super().__init__()
        self._clock, self._rng = clock, np.random.default_rng(1)
        self.echoes: dict[tuple[int, int], float] = {}

    def range_m(self, sensor: int) -> float:
        """Hear something between 0.5 and 3 m."""
        inches = int(self._rng.integers(20, 120))
        range_m = inches * METRES_PER_INCH
        self.echoes[sensor, inches] = self._clock.now() + 2.0 * range_m / SOUND_M_S
        return range_m


class Bench:
    """Answers readings and matches the answers with what the base understood."""

    def __init__(self, clock: WallClock, floor: Surprises, line: EmulatedLine) -> None:
        """Join the domain of the driver's node."""
        self.clock, self.floor, self.line = clock, floor, line
        self.latencies: list[float] = []
        self.superseded = 0
        self._pending: deque[tuple[int, float]] = deque(maxlen=len(SPEEDS) // 2)
        self._answers = 0
        self.node = rclpy.create_node("scout_latency")
        self._commands = self.node.create_publisher(TwistStamped, "cmd_vel", SENSOR)
        self.node.create_subscription(SonarRing, "sonar", self._on_sonar, SENSOR)

    def _on_sonar(self, msg: SonarRing) -> None:
        self._match()
        for ping in sonar_from_msg(msg).pings:
            echo_s = self.floor.echoes.pop((ping.sensor, round(ping.range_m / METRES_PER_INCH)), None)
            if echo_s is not None:
                units = SPEEDS[self._answers % len(SPEEDS)]
                self._answers += 1
                self._pending.append((units, echo_s))
                # A hair above the unit, so that rounding on the way does not matter.
                self._commands.publish(velocity_to_msg(Velocity((units + 0.01) * METRES_PER_UNIT, 0.0), 0))

    def _match(self) -> None:
        while self.line.commands:
            when, command = self.line.commands.popleft()
            if command.kind is not CommandKind.VELOCITY:
                continue
            for entry in list(self._pending):
                if when > entry[1] + SUPERSEDED_S:
                    self.superseded += 1
                    self._pending.remove(entry)
                elif entry[0] == command.values[0] and when > entry[1]:
                    self.latencies.append(when - entry[1])
                    self._pending.remove(entry)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    options = parser.parse_args()
    clock, emulator = WallClock(), EmulatorConfig(tick_ms=2)
    floor = Surprises(clock)
    line = EmulatedLine(EmulatedBase(floor, emulator), emulator, Faults(FaultConfig(), np.random.default_rng(0)))
    with tempfile.TemporaryDirectory() as folder, private_domain() as domain:
        os.environ.update(ON_ONE_THREAD | dict(os.environ) | domain.environment)  # as in a run
        port = PtyPort(str(Path(folder) / "line"))
        server = EmulatorServer(line, port, clock, 1.0)
        server.start()
        rclpy.init()
        bench = Bench(clock, floor, line)
        executor = make_executor()
        executor.add_node(bench.node)
        command = [sys.executable, "-m", "scout_driver.scout_node", "--ros-args"]
        command += ["-p", f"port:={port.address}", "-p", "acceleration_m_s2:=3.0"]
        driver = subprocess.Popen(command)
        try:
            process = psutil.Process(driver.pid)
            _spin(executor, 5.0)
            bench.latencies.clear()
            before, began_s = process.cpu_times(), time.monotonic()
            _spin(executor, options.seconds)
            after, lasted_s = process.cpu_times(), time.monotonic() - began_s
        finally:
            driver.terminate()
            driver.wait()
            server.stop()
            rclpy.try_shutdown()
    cpu = (after.user + after.system - before.user - before.system) / lasted_s
    quantiles = np.percentile(1e3 * np.array(bench.latencies), [50, 90, 99, 100])
    bound_ms = 1e3 * DriverConfig().cycle_s + 20.0
    figures = "median {:.1f} ms, p90 {:.1f}, p99 {:.1f}, worst {:.1f}".format(*quantiles)
    print(f"echo to wheel command: {figures} (bound at p99: {bound_ms:.0f})")
    print(f"readings answered: {len(bench.latencies)}; answers overtaken by the next: {bench.superseded}")
    print(f"driver process: {100 * cpu:.1f} % of a core")


def _spin(executor: Executor, seconds: float) -> None:
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        executor.spin_once(timeout_sec=0.1)


if __name__ == "__main__":
    main()
