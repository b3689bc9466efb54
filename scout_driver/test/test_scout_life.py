"""The base's set-up, its stop on the way out, and what the driver does while it cannot be sure of either."""

from unittest.mock import Mock

import pytest
from scout_bench import FORWARD, Bench, Wall

from hslam_types.se2 import SE2
from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.emulator.loopback import wait_until
from scout_driver.motion_guard import Hold
from scout_driver.protocol.commands import Command, CommandKind
from scout_driver.units import METRES_PER_UNIT, speed_units


def kinds(bench: Bench) -> list[CommandKind]:
    """Return the types of the commands that have reached the base."""
    return [command.kind for _, command in bench.line.commands]


def expected_setup(config: DriverConfig) -> list[Command]:
    """Return the set-up with every value."""
    units = speed_units(config.wheel_acceleration_m_s2)
    return [
        Command(CommandKind.STOP),
        Command(CommandKind.CONFIGURE_WATCHDOG, (config.watchdog_s,)),
        Command(CommandKind.ACCELERATION, (units, units, 0)),
        Command(CommandKind.CONFIGURE_SONAR, (config.sonar_rate, *config.firing_order())),
    ]


def test_a_base_that_was_silent_for_long_is_set_up_again() -> None:
    """It may have been switched off and on where its counters tell nothing of it: at their origin."""
    bench = Bench(config=DriverConfig(watchdog_s=3))
    bench.run(1.0, None)
    assert [command for _, command in bench.line.commands][:4] == expected_setup(bench.config)
    bench.silence(deaf=True)
    bench.run(2.5, None)
    bench.line.commands.clear()
    bench.silence(deaf=False)
    bench.run(0.6, FORWARD)
    assert [command for _, command in bench.line.commands][:4] == expected_setup(bench.config)


def test_readings_are_handed_out_only_after_the_set_up() -> None:
    """Before it, nobody knows in what order the sonars are fired."""
    bench = Bench(floor=Wall())
    wait_until(bench.line, bench.clock, 3.0)
    readings = bench.run(0.15, None)
    assert CommandKind.CONFIGURE_SONAR not in kinds(bench)
    assert readings
    assert max(readings[-1].state.sonar) > 0
    assert not any(reading.pings for reading in readings)


def test_limp_and_hold_are_both_told_to_a_base_that_stands() -> None:
    bench = Bench()
    bench.run(1.0, None)
    for limp, kind in ((True, CommandKind.LIMP), (False, CommandKind.STOP)):
        bench.line.commands.clear()
        bench.driver.set_limp(limp=limp)
        bench.run(0.3, None)
        assert kinds(bench)[0] is kind
        assert set(kinds(bench)[1:]) == {CommandKind.STATE}


def test_a_command_is_not_kept_over_a_push_by_hand() -> None:
    bench = Bench(config=DriverConfig(command_timeout_s=1.0))
    bench.run(1.0, FORWARD)
    bench.driver.set_limp(limp=True)
    bench.run(0.2, None)
    bench.line.commands.clear()
    bench.driver.set_limp(limp=False)
    bench.run(0.5, None)
    assert bench.wheel_commands == []


def test_a_stop_that_the_base_does_not_confirm_is_not_reported_as_one() -> None:
    bench = Bench()
    bench.run(1.0, FORWARD)
    bench.silence(deaf=True)
    assert not bench.driver.disable()


def test_a_base_whose_line_is_gone_is_not_known_to_stand() -> None:
    bench = Bench()
    bench.run(1.0, None)
    bench.line.unplug(bench.clock.now(), 5.0)
    bench.run(0.3, None)
    assert not bench.driver.disable()


@pytest.mark.parametrize("stop", [True, False])
def test_closing_stops_the_base_unless_told_otherwise(*, stop: bool) -> None:
    bench = Bench()
    bench.run(1.0, FORWARD)
    bench.line.commands.clear()
    bench.driver.close(stop=stop)
    assert (CommandKind.STOP in kinds(bench)) == stop
    assert (bench.speed == 0.0) == stop
    assert not bench.driver.connected


def test_states_that_are_not_believed_are_no_answers() -> None:
    """Counters that jump in every frame: nobody knows where the base is, so it is stopped."""
    bench = Bench()
    bench.run(1.0, FORWARD)
    for i in range(15):
        bench.floor.encoder_pose = SE2(10.0 + 15.0 * (i % 3), 0.0, 0.0)
        bench.run(0.06, FORWARD)
    assert bench.driver.hold() is Hold.LINE
    assert kinds(bench)[-1] is CommandKind.STOP
    assert bench.speed < 0.1


def test_a_base_that_ignores_its_rebasing_is_driven_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(config=DriverConfig(rebase_at_m=1.0))
    monkeypatch.setattr(bench.base, "_define", lambda *_: None)
    bench.run(6.0, FORWARD)
    bench.line.commands.clear()
    bench.run(1.0, Velocity(0.1, 0.0))
    assert CommandKind.DEFINE_POSITION in kinds(bench)
    assert len(bench.wheel_commands) >= 6
    assert bench.speed == pytest.approx(0.1, abs=0.01)


def test_no_wheel_is_asked_for_more_than_its_limit() -> None:
    bench = Bench(config=DriverConfig(wheel_speed_max_m_s=0.3))
    bench.run(2.0, Velocity(0.6, 1.0))
    fastest = max(abs(wheel) for wheels in bench.wheel_commands for wheel in wheels)
    assert fastest * METRES_PER_UNIT == pytest.approx(0.3, abs=METRES_PER_UNIT)


def test_a_line_that_is_gone_is_looked_for_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench()
    bench.run(0.5, None)
    bench.line.unplug(bench.clock.now(), 5.0)
    attempts = Mock(wraps=bench.driver._open)
    monkeypatch.setattr(bench.driver, "_open", attempts)
    bench.run(4.0, None)
    assert 6 <= attempts.call_count <= 4.0 / bench.config.reconnect_s + 1
