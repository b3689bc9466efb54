"""Driver and emulated base on a virtual clock: motion, safety, recovery, and every fault."""

import math

import numpy as np
import pytest
from hash_seeds import under_two_hash_seeds
from hypothesis import given, settings
from hypothesis import strategies as st
from scout_bench import FORWARD, STOPPING_M, Bench, Wall

from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity
from scout_driver.config import DriverConfig
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.floor import EmptyPlane
from scout_driver.emulator.loopback import wait_until
from scout_driver.motion_guard import Hold
from scout_driver.protocol.commands import Command, CommandKind, wheel_command
from scout_driver.protocol.replies import STATE_REPLIES, state_from_frame


def test_drives_where_it_is_told() -> None:
    bench = Bench()
    readings = bench.run(3.0, Velocity(0.2, 0.5))
    assert readings[-1].velocity == pytest.approx((0.2, 0.5), abs=0.02)
    bench.run(1.5, Velocity())
    error = bench.floor.true_pose.to(bench.run(0.1, None)[-1].base_in_odom)
    assert math.hypot(error.x, error.y) < 0.004
    assert abs(wrap(error.theta)) < 0.002
    assert bench.speed == 0.0


def test_acceleration_stays_within_its_limit() -> None:
    bench = Bench()
    bench.run(0.5, None)
    speeds = [0.0]
    for _ in range(12):
        bench.run(0.06, Velocity(0.3, 0.0))
        speeds.append(bench.speed)
    assert max(np.diff(speeds)) <= bench.config.acceleration_m_s2 * 0.06 * 2 + 0.003
    assert speeds[-1] == pytest.approx(0.3, abs=0.01)


def test_a_base_that_stands_is_only_asked_for_its_state() -> None:
    bench = Bench()
    bench.run(1.0, None)
    bench.line.commands.clear()
    bench.run(3.0, Velocity())
    assert {command.kind for _, command in bench.line.commands} == {CommandKind.STATE}


def test_the_base_is_set_up_before_it_is_moved() -> None:
    bench = Bench()
    bench.run(1.0, FORWARD)
    kinds = [command.kind for _, command in bench.line.commands]
    assert kinds[:5] == [
        CommandKind.STOP,
        CommandKind.CONFIGURE_WATCHDOG,
        CommandKind.ACCELERATION,
        CommandKind.CONFIGURE_SONAR,
        CommandKind.VELOCITY,
    ]


def test_silence_of_the_commander_stops_the_base() -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    start = bench.floor.true_pose.x
    bench.run(0.9, None)
    assert bench.driver.hold() is Hold.NO_COMMAND
    assert bench.floor.true_pose.x - start < 0.25 * (0.5 + 0.06) + STOPPING_M
    bench.run(0.2, None)
    assert bench.speed == 0.0


def test_a_dead_computer_is_stopped_by_the_watchdog() -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    wait_until(bench.line, bench.clock, bench.clock.now() + 2.0)
    assert bench.speed == 0.0
    assert bench.base.aborts == 1


def test_a_bumper_stops_the_base_and_lets_it_only_back_off() -> None:
    bench = Bench(config=DriverConfig(bumper_resume_s=3600.0), floor=Wall())
    bench.run(6.0, FORWARD)
    assert bench.driver.hold() is Hold.BUMPER
    stopped_at = bench.floor.true_pose.x
    assert stopped_at < 1.0 + 0.25 * 0.1 + STOPPING_M
    bench.run(2.0, Velocity(0.2, 0.3))
    assert bench.floor.true_pose.x == pytest.approx(stopped_at, abs=0.02)
    assert abs(bench.floor.true_pose.theta) > 0.2
    bench.run(2.0, Velocity(-0.3, 0.0))
    assert stopped_at - 0.1 * 2.0 - 0.05 < bench.floor.true_pose.x < stopped_at - 0.1


def test_some_time_after_a_contact_everything_is_allowed_again() -> None:
    bench = Bench(floor=Wall())
    bench.run(5.5, FORWARD)
    bench.run(5.0, Velocity(-0.3, 0.0))
    assert bench.speed == pytest.approx(0.3, abs=0.01)


def test_a_bumper_may_be_told_to_hold_the_base_for_good() -> None:
    strict = DriverConfig(bumper_resume_s=3600.0, bumper_reverse_m_s=0.0, bumper_turn_rad_s=0.0)
    bench = Bench(config=strict, floor=Wall())
    bench.run(6.0, FORWARD)
    before = bench.floor.true_pose
    bench.run(3.0, Velocity(-0.2, 0.4))
    assert bench.floor.true_pose == before


def test_disabling_stops_the_base_and_confirms_it() -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    assert bench.driver.disable()
    assert bench.speed == 0.0
    bench.run(1.0, FORWARD)
    assert bench.speed == 0.0


def test_commands_from_before_enabling_are_forgotten() -> None:
    bench = Bench()
    bench.driver.disable()
    bench.run(1.0, FORWARD)
    bench.driver.enable()
    bench.run(0.3, None)
    assert bench.speed == 0.0


def test_limp_lets_the_base_be_pushed() -> None:
    bench = Bench()
    bench.run(1.0, FORWARD)
    bench.driver.set_limp(limp=True)
    bench.run(1.0, FORWARD)
    assert bench.driver.hold() is Hold.LIMP
    assert bench.speed == 0.0
    bench.driver.set_limp(limp=False)
    bench.run(1.0, FORWARD)
    assert bench.speed > 0.2


@pytest.mark.parametrize("speed", [math.nan, math.inf])
def test_a_command_that_is_no_number_is_a_stop(speed: float) -> None:
    bench = Bench()
    bench.run(1.0, FORWARD)
    bench.run(1.0, Velocity(speed, 0.0))
    assert bench.speed == 0.0


def test_unplugging_recovers_by_itself_and_waits_for_a_new_command() -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    bench.line.unplug(bench.clock.now(), 5.0)
    bench.run(4.0, FORWARD)
    assert bench.speed == 0.0
    assert bench.driver.line_losses == 1
    bench.run(2.0, None)
    assert bench.driver.connected
    assert bench.speed == 0.0
    readings = bench.run(2.0, FORWARD)
    assert bench.speed == pytest.approx(0.25, abs=0.01)
    assert readings[-1].base_in_odom.x == pytest.approx(bench.floor.true_pose.x, abs=0.03)


def test_a_silent_base_is_stopped_as_soon_as_it_hears_again() -> None:
    bench = Bench()
    bench.run(2.0, FORWARD)
    bench.driver.guard.forget_command()
    bench.line.commands.clear()
    bench.run(0.2, None)
    assert bench.line.commands[0][1].kind is CommandKind.STOP


def test_the_counters_are_rebased_on_the_way_without_a_jump() -> None:
    bench = Bench(config=DriverConfig(rebase_at_m=1.0))
    readings = bench.run(30.0, FORWARD)
    steps = np.diff([reading.base_in_odom.x for reading in readings])
    assert bench.driver.odometry.rebases >= 6
    assert max(abs(steps[60:] - np.median(steps))) < 0.006
    bench.run(1.5, Velocity())
    assert bench.run(0.2, None)[-1].base_in_odom.x == pytest.approx(bench.floor.true_pose.x, abs=0.01)


def test_beyond_the_range_of_the_counters() -> None:
    bench = Bench()
    readings = bench.run(100.0 / 0.6, Velocity(0.6, 0.0))
    assert readings[-1].base_in_odom.x > 90.0
    assert readings[-1].base_in_odom.x == pytest.approx(bench.floor.true_pose.x, abs=0.05)
    assert bench.driver.odometry.rejected == 0


def test_readings_of_the_sonar_have_their_own_age() -> None:
    bench = Bench(floor=Wall())
    readings = bench.run(3.0, Velocity(0.3, 0.0))
    pings = [(fired_s, ping) for reading in readings for fired_s, ping in reading.pings]
    assert len(pings) == pytest.approx(2.7 / 0.06, abs=4)
    order = bench.config.firing_order()
    assert [ping.sensor for _, ping in pings[:16]] == list(order)
    track = [(reading.stamp_s, reading.base_in_odom.x) for reading in readings]
    stamps, xs = (np.array(column) for column in zip(*track, strict=True))
    for fired_s, ping in pings:
        assert abs(max(0.2, 1.0 - float(np.interp(fired_s, stamps, xs))) - ping.range_m) < 0.02


def test_a_wheel_order_the_other_way_round() -> None:
    bench = Bench(config=DriverConfig(swap_wheels=True))
    bench.run(1.0, Velocity(0.0, 0.5))
    sent = [command for _, command in bench.line.commands if command.kind is CommandKind.VELOCITY][-1]
    assert sent.values[0] < 0 < sent.values[1]


FAULTS = ["flipped", "lost", "doubled", "late", "nak", "silent", "deaf", "short", "repeated", "late_reply", "unplugged"]


@pytest.mark.parametrize("kind", FAULTS)
@pytest.mark.parametrize("rate", [0.01, 0.1])
def test_no_fault_moves_a_base_that_nobody_commands(kind: str, rate: float) -> None:
    bench = Bench(faults=FaultConfig(**{kind: rate}), seed=5)
    bench.run(20.0, None)
    bench.run(10.0, Velocity())
    assert bench.floor.true_pose == SE2()


@pytest.mark.parametrize("kind", FAULTS)
def test_after_any_fault_has_passed_the_driver_drives_again(kind: str) -> None:
    bench = Bench(faults=FaultConfig(**{kind: 0.1}, unplugged_s=0.5), seed=6)
    bench.run(10.0, FORWARD)
    bench.silence(deaf=False)
    bench.run(4.0, FORWARD)
    readings = bench.run(2.0, FORWARD)
    assert len(readings) >= 30
    assert bench.speed == pytest.approx(0.25, abs=0.01)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.binary(max_size=60), min_size=5, max_size=30), st.integers(0, 2**32 - 1))
def test_no_reply_of_any_content_makes_the_driver_move_the_base(replies: list[bytes], seed: int) -> None:
    bench = Bench(seed=seed)
    bench.run(0.6, None)
    bench.line.commands.clear()
    for reply in replies:
        bench.line._leaving.append((bench.clock.now() + 0.001, reply))
        bench.run(0.12, None)
    harmless = {CommandKind.STATE, CommandKind.STOP, CommandKind.CONFIGURE_WATCHDOG, CommandKind.ACCELERATION}
    harmless |= {CommandKind.CONFIGURE_SONAR, CommandKind.DEFINE_POSITION}
    assert {command.kind for _, command in bench.line.commands} <= harmless
    assert bench.speed == 0.0


@pytest.mark.parametrize("kind", sorted(STATE_REPLIES - {CommandKind.WAIT_STOPPED}))
def test_the_emulated_base_answers_every_command_with_its_own_type(kind: CommandKind) -> None:
    base = EmulatedBase(EmptyPlane(), EmulatorConfig())
    sizes = {CommandKind.CONFIGURE_SONAR: 17, CommandKind.CONFIGURE_WATCHDOG: 1}
    sizes |= {CommandKind.DEFINE_POSITION: 2, CommandKind.DEFINE_ANGLE: 2}
    sizes |= dict.fromkeys((CommandKind.ACCELERATION, CommandKind.SPEED, CommandKind.MOVE, CommandKind.VELOCITY), 3)
    reply = base.handle(Command(kind, (1,) * sizes.get(kind, 0)))
    assert reply is not None
    assert reply.kind == kind
    assert len(state_from_frame(reply).sonar) == 16


def test_the_emulated_base_moves_a_distance_and_says_when_it_stands() -> None:
    floor = EmptyPlane()
    base = EmulatedBase(floor, EmulatorConfig())
    base.handle(wheel_command(CommandKind.MOVE, 200, 200))
    base.advance(0.1)
    assert base.handle(Command(CommandKind.WAIT_STOPPED, (1, 1, 0, 60))) is None
    base.advance(10.0)
    assert base.waited() is not None
    assert floor.true_pose.x == pytest.approx(0.508, abs=0.02)


def test_defining_position_and_angle_moves_the_encoders_alone() -> None:
    floor = EmptyPlane()
    base = EmulatedBase(floor, EmulatorConfig())
    base.handle(Command(CommandKind.DEFINE_POSITION, (100, -50)))
    base.handle(Command(CommandKind.DEFINE_ANGLE, (900, 0)))
    state = base.state()
    assert (state.x, state.y, state.heading) == (100, -50, 900)
    base.handle(Command(CommandKind.ZERO))
    assert (base.state().x, base.state().heading) == (0, 0)
    assert floor.true_pose == SE2()


def test_a_bad_frame_is_answered_by_nak_where_configured() -> None:
    bench = Bench(emulator=EmulatorConfig(nak_bad_frames=True), faults=FaultConfig(flipped=0.01), seed=2)
    bench.run(20.0, Velocity())
    assert bench.driver.counts.refused > 0
    assert Bench(emulator=EmulatorConfig()).driver.counts.refused == 0


def end_of_a_faulty_run() -> str:
    """Return the last reading of a run over a bad line, and what happened on that line."""
    bench = Bench(faults=FaultConfig(flipped=0.01, lost=0.005, late=0.002), seed=11)
    return repr((bench.run(10.0, FORWARD)[-1], bench.driver.counts))


def test_the_same_seed_gives_the_same_run() -> None:
    first, second = under_two_hash_seeds(end_of_a_faulty_run)
    assert first == second
