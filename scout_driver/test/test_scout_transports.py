"""Real transports against the emulator in a thread: a pseudo-terminal, TCP, and what is not there."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from hslam_types.sensing import Velocity
from scout_driver.clock import WallClock
from scout_driver.config import DriverConfig
from scout_driver.driver import ScoutDriver
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.faults import Faults
from scout_driver.emulator.floor import EmptyPlane
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.ports import Port, PortError, open_port
from scout_driver.emulator.server import EmulatorServer
from scout_driver.errors import LineLostError
from scout_driver.transport import open_transport

FACTOR = 5.0
"""Emulated seconds a wall second."""
PATIENCE_S = 60.0


class Served:
    """An emulated base on a real port, and a driver that speaks to it."""

    def __init__(self, port: Port) -> None:
        """Start the server's thread; the driver opens its line when it first cycles."""
        config = EmulatorConfig()
        self.floor = EmptyPlane()
        self.line = EmulatedLine(
            EmulatedBase(self.floor, config), config, Faults(FaultConfig(), np.random.default_rng(0))
        )
        self.clock = WallClock(FACTOR)
        self.server = EmulatorServer(self.line, port, self.clock, FACTOR)
        self.server.start()
        own = DriverConfig(port=port.address, reconnect_s=0.06)
        self.driver = ScoutDriver(own, self.clock, lambda: open_transport(own.port, own.baud, FACTOR))
        self.driver.enable()

    def answered(self, states: int, command: Velocity) -> bool:
        """Cycle until so many more states have come; False if that takes too long."""
        end_s, left = self.clock.now() + PATIENCE_S, states
        while left and self.clock.now() < end_s:
            self.driver.command(command)
            left -= self.driver.cycle() is not None
        return left == 0


@pytest.fixture(params=["pty", "tcp"])
def served(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Served]:
    """Both kinds of port."""
    made = Served(open_port("tcp://127.0.0.1:0" if request.param == "tcp" else str(tmp_path / "line")))
    yield made
    made.driver.close()
    made.server.stop()


def test_drives_recovers_and_stops(served: Served) -> None:
    assert served.answered(60, Velocity(0.2, 0.0))
    assert served.floor.true_pose.x > 0.1
    served.line.unplug(served.clock.now(), 1.0)
    # The thread notices at its next turn; the driver must lose the line, find it again, and go on.
    assert served.answered(60, Velocity(0.2, 0.0))
    assert served.driver.line_losses >= 1
    assert served.driver.disable()
    assert served.floor.wheels == (0.0, 0.0)
    assert served.server.failure is None


@pytest.mark.parametrize("port", ["/dev/does-not-exist", "tcp://127.0.0.1:1", "tcp://nowhere", "tcp://x:99999999"])
def test_a_line_that_is_not_there_is_an_error_of_one_line(port: str) -> None:
    with pytest.raises(LineLostError) as caught:
        open_transport(port, 38400)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("address", ["tcp://nowhere", "/does/not/exist/line"])
def test_a_port_that_cannot_be_opened_is_an_error(address: str) -> None:
    with pytest.raises(PortError):
        open_port(address)
