"""What must never move a base: a stop that was released, a line that came back, a driver that was away."""

import math
from collections.abc import Callable

import pytest
from scout_bench import FORWARD, Bench

from hslam_types.se2 import SE2
from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.emulator.loopback import wait_until
from scout_driver.motion_guard import Hold
from scout_driver.protocol.commands import CommandKind, wheel_command
from scout_driver.units import METRES_PER_UNIT

FASTEST_START_M_S = 2.0 * DriverConfig().cycle_s * DriverConfig().acceleration_m_s2 + METRES_PER_UNIT
"""The first velocity asked of a base that stands: two cycles' worth of acceleration, rounded to a unit."""


def stopped_by_the_button(bench: Bench) -> None:
    """Drive, press the emergency stop until the base stands, with somebody commanding on, and release it."""
    bench.run(2.0, FORWARD)
    bench.base.emergency_stop = True
    bench.run(1.0, FORWARD)
    assert bench.driver.hold() is Hold.EMERGENCY_STOP
    assert bench.speed == 0.0
    bench.line.commands.clear()
    bench.base.emergency_stop = False


def test_a_command_is_not_kept_over_an_emergency_stop() -> None:
    bench = Bench(config=DriverConfig(command_timeout_s=1.0))
    bench.run(2.0, FORWARD)
    bench.base.emergency_stop = True
    bench.run(0.2, None)
    bench.base.emergency_stop = False
    bench.line.commands.clear()
    for _ in range(20):
        bench.run(0.06, None)
        assert bench.wheel_commands == []
    assert bench.speed == 0.0


def test_releasing_the_emergency_stop_moves_nothing_however_eagerly_somebody_commands() -> None:
    bench = Bench()
    stopped_by_the_button(bench)
    bench.run(5.0, FORWARD)
    assert bench.driver.hold() is Hold.EMERGENCY_RELEASED
    assert bench.wheel_commands == []
    assert bench.speed == 0.0


def test_neither_silence_nor_a_lost_line_nor_a_new_life_of_the_node_undoes_an_emergency_stop() -> None:
    bench = Bench()
    stopped_by_the_button(bench)
    bench.run(2.0, None)
    bench.line.unplug(bench.clock.now(), 1.0)
    bench.run(3.0, FORWARD)
    bench.driver.disable()
    bench.driver.enable()
    bench.run(2.0, FORWARD)
    assert bench.driver.hold() is Hold.EMERGENCY_RELEASED
    assert bench.wheel_commands == []


@pytest.mark.parametrize("no_number", [Velocity(math.nan, 0.0), Velocity(0.0, math.nan), Velocity(0.0, math.inf)])
def test_a_command_that_is_no_number_does_not_undo_an_emergency_stop(no_number: Velocity) -> None:
    bench = Bench()
    stopped_by_the_button(bench)
    bench.run(0.2, no_number)
    bench.run(1.0, FORWARD)
    assert bench.wheel_commands == []


def test_a_command_to_stand_still_counts_only_after_the_release() -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    bench.base.emergency_stop = True
    bench.run(1.0, Velocity())
    bench.base.emergency_stop = False
    bench.run(0.1, None)  # the driver has heard of the release
    bench.line.commands.clear()
    bench.run(1.0, FORWARD)
    assert bench.wheel_commands == []
    bench.run(0.1, Velocity())
    bench.run(1.0, FORWARD)
    assert bench.speed == pytest.approx(0.25, abs=0.01)


def test_an_emergency_stop_pressed_before_the_driver_came_holds_as_well() -> None:
    bench = Bench()
    bench.base.emergency_stop = True
    bench.run(1.0, FORWARD)
    bench.base.emergency_stop = False
    bench.run(1.0, FORWARD)
    assert bench.wheel_commands == []


def test_a_command_is_not_kept_over_a_silence_of_the_base() -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    bench.silence(deaf=True)
    bench.run(0.9, FORWARD)
    assert bench.driver.hold() is Hold.LINE
    bench.silence(deaf=False)
    bench.line.commands.clear()
    bench.run(1.0, None)
    assert bench.driver.counts.answered > 0
    assert bench.wheel_commands == []
    assert bench.speed == 0.0


@pytest.mark.parametrize("outage_s", [0.1, 0.4])
def test_a_command_is_not_kept_over_a_lost_line(outage_s: float) -> None:
    """The outage is shorter than the time after which a command is stale, or the base silent."""
    bench = Bench(config=DriverConfig(reconnect_s=0.05, command_timeout_s=1.0, line_timeout_s=1.0))
    bench.run(2.0, FORWARD)
    bench.line.unplug(bench.clock.now(), outage_s)
    while not bench.line.plugged(bench.clock.now()):
        bench.run(0.06, FORWARD)
    assert bench.driver.line_losses == 1
    bench.line.commands.clear()
    bench.run(1.0, None)
    assert bench.driver.connected
    assert bench.wheel_commands == []
    assert bench.speed == 0.0


def test_a_command_is_not_kept_over_a_base_switched_off_and_on() -> None:
    bench = Bench(config=DriverConfig(command_timeout_s=1.0))
    bench.run(2.0, FORWARD)
    hold_by_new_counters(bench)
    bench.line.commands.clear()
    bench.run(0.9, None)
    kinds = [command.kind for _, command in bench.line.commands]
    assert kinds[:2] == [CommandKind.STOP, CommandKind.CONFIGURE_WATCHDOG]
    assert bench.wheel_commands == []


def test_a_driver_that_was_away_speeds_up_no_faster_for_it() -> None:
    bench = Bench()
    bench.run(1.0, None)
    wait_until(bench.line, bench.clock, bench.clock.now() + 0.45)
    bench.line.commands.clear()
    bench.driver.command(Velocity(0.6, 0.0))
    bench.driver.cycle()
    (wheels,) = bench.wheel_commands
    assert 0 < max(wheels) * METRES_PER_UNIT <= FASTEST_START_M_S


def hold_by_silence(bench: Bench) -> None:
    bench.run(1.5, None)


def hold_by_limping(bench: Bench) -> None:
    bench.driver.set_limp(limp=True)
    bench.run(1.5, FORWARD)
    bench.driver.set_limp(limp=False)


def hold_by_deactivating(bench: Bench) -> None:
    bench.driver.disable()
    bench.driver.enable()


def hold_by_setting_up(bench: Bench) -> None:
    bench.silence(deaf=True)
    bench.run(2.5, FORWARD)
    bench.silence(deaf=False)


def hold_by_new_counters(bench: Bench) -> None:
    bench.floor.encoder_pose = SE2(-20.0, 5.0, 1.0)
    while bench.driver.odometry.jumps == 0:
        bench.run(0.06, FORWARD)


@pytest.mark.parametrize(
    "hold", [hold_by_silence, hold_by_limping, hold_by_deactivating, hold_by_setting_up, hold_by_new_counters]
)
def test_after_a_hold_the_base_speeds_up_from_rest(hold: Callable[[Bench], None]) -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    hold(bench)
    bench.line.commands.clear()
    while not bench.wheel_commands:
        bench.run(0.06, FORWARD)
    assert 0 < max(bench.wheel_commands[0]) * METRES_PER_UNIT <= FASTEST_START_M_S


@pytest.mark.parametrize("rogue", [(100, 100), (0, 100), (-100, 0)])
def test_a_base_that_moves_unasked_is_stopped(rogue: tuple[int, int]) -> None:
    """A velocity that a damaged frame made, or another program on the line."""
    bench = Bench()
    bench.run(1.0, None)
    bench.base.handle(wheel_command(CommandKind.VELOCITY, *rogue))
    bench.run(0.6, None)
    assert bench.speed == 0.0
    assert not bench.base.aborts  # by the driver, not by the watchdog


def test_a_base_told_to_move_is_told_to_stop_though_it_has_not_begun_to_move() -> None:
    """The answer to a velocity shows the wheels as they were before it."""
    bench = Bench()
    bench.run(1.0, None)
    bench.line.commands.clear()
    bench.driver.command(FORWARD)
    bench.driver.cycle()
    bench.driver.command(Velocity())
    bench.driver.cycle()
    assert [command.kind for _, command in bench.line.commands] == [CommandKind.VELOCITY, CommandKind.STOP]
