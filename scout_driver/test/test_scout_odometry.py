"""Counters that overflow, are set anew or lie; clocks that do the same; sonars of unknown age."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.se2 import SE2, wrap
from scout_driver.board_clock import BoardClock
from scout_driver.config import DriverConfig
from scout_driver.odometry import Odometry
from scout_driver.protocol.replies import State
from scout_driver.sonar_schedule import SonarSchedule
from scout_driver.units import METRES_PER_UNIT, RADIANS_PER_UNIT

CYCLE_S = 0.06
SPEED = 100
"""0.254 m/s in wire units."""


def _state(pose: SE2, right: int = 0, left: int = 0, sonar: tuple[int, ...] = (50,) * 16) -> State:
    heading = round(pose.theta / RADIANS_PER_UNIT) % 3600
    x, y = round(pose.x / METRES_PER_UNIT), round(pose.y / METRES_PER_UNIT)
    return State(sonar=sonar, bumper=0, x=x, y=y, heading=heading, right=right, left=left)


def _drive(odometry: Odometry, steps: int, *, offset_m: float = 0.0, start: int = 0) -> None:
    """Feed states of a straight drive along x whose counters are shifted by ``offset_m``."""
    for i in range(start, start + steps):
        x = SPEED * METRES_PER_UNIT * CYCLE_S * i
        assert odometry.update(_state(SE2(x - offset_m, 0.0, 0.0), SPEED, SPEED), i * CYCLE_S) is not None


@given(st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-1.5, 1.5)), min_size=1, max_size=60))
def test_follows_the_counters_to_within_their_resolution(motions: list[tuple[float, float]]) -> None:
    odometry, pose = Odometry(DriverConfig()), SE2()
    odometry.update(_state(pose), 0.0)
    for i, (forward, turn) in enumerate(motions, start=1):
        pose = pose @ SE2(forward * CYCLE_S, 0.0, turn * CYCLE_S)
        assert odometry.update(_state(pose), i * CYCLE_S) is not None
    error = pose.to(odometry.base_in_odom)
    assert math.hypot(error.x, error.y) < 0.004
    assert abs(wrap(error.theta)) < math.radians(0.11)


def test_rebasing_leaves_no_jump() -> None:
    odometry = Odometry(DriverConfig(rebase_at_m=1.0))
    _drive(odometry, 70)
    assert odometry.needs_rebase()
    odometry.expect_rebase()
    # The counters were zeroed as state 69 was read, so the next one shows one cycle's way.
    _drive(odometry, 30, offset_m=SPEED * METRES_PER_UNIT * CYCLE_S * 69, start=70)
    assert not odometry.needs_rebase()
    assert odometry.rebases == 1
    assert odometry.jumps == 0
    assert abs(odometry.base_in_odom.x - SPEED * METRES_PER_UNIT * CYCLE_S * 99) < 0.004


def test_an_overflow_that_no_rebase_prevented_is_unwrapped() -> None:
    odometry = Odometry(DriverConfig())
    for i in range(40):
        units = (32767 - 300 + 15 * i + 32767) % 65535 - 32767
        state = State((50,) * 16, 0, units, -units, 3150, SPEED, SPEED)
        assert odometry.update(state, i * CYCLE_S) is not None
    assert odometry.base_in_odom.x == pytest.approx(15 * 39 * METRES_PER_UNIT * math.sqrt(2.0), abs=1e-6)
    assert (odometry.rejected, odometry.jumps) == (0, 0)


def test_a_lost_rebase_changes_nothing() -> None:
    odometry = Odometry(DriverConfig(rebase_at_m=1.0))
    _drive(odometry, 70)
    odometry.expect_rebase()
    _drive(odometry, 30, start=70)
    assert odometry.rebases == 0
    assert abs(odometry.base_in_odom.x - SPEED * METRES_PER_UNIT * CYCLE_S * 99) < 0.004


def test_one_damaged_pose_is_not_believed() -> None:
    odometry = Odometry(DriverConfig())
    _drive(odometry, 10)
    assert odometry.update(_state(SE2(40.0, 3.0, 2.0)), 10 * CYCLE_S) is None
    _drive(odometry, 10, start=11)
    assert (odometry.rejected, odometry.jumps) == (1, 0)
    assert abs(odometry.base_in_odom.x - SPEED * METRES_PER_UNIT * CYCLE_S * 20) < 0.004


def test_counters_lost_behind_our_back_keep_the_pose() -> None:
    odometry = Odometry(DriverConfig())
    odometry.update(_state(SE2(5.0, 2.0, 1.0)), 0.0)
    before = odometry.base_in_odom
    believed = [odometry.update(_state(SE2()), 1.0 + i * CYCLE_S) is not None for i in range(4)]
    assert odometry.jumps <= 1
    assert believed[-1]
    assert odometry.base_in_odom == before


def test_zeroing_begins_anew_where_the_base_is() -> None:
    odometry = Odometry(DriverConfig())
    _drive(odometry, 20)
    odometry.zero()
    _drive(odometry, 11, start=20)
    assert odometry.base_in_odom.x == pytest.approx(10 * SPEED * METRES_PER_UNIT * CYCLE_S, abs=0.003)


def test_calibration_scales_distance_and_rotation() -> None:
    odometry = Odometry(DriverConfig(distance_scale=1.1, rotation_scale=0.9))
    odometry.update(_state(SE2()), 0.0)
    odometry.update(_state(SE2(0.0, 0.0, 0.2)), 0.1)
    assert odometry.base_in_odom.theta == pytest.approx(0.18, abs=0.001)
    odometry.update(_state(SE2(0.1 * math.cos(0.2), 0.1 * math.sin(0.2), 0.2)), 0.2)
    assert math.hypot(odometry.base_in_odom.x, odometry.base_in_odom.y) == pytest.approx(0.11, abs=0.004)
    assert math.atan2(odometry.base_in_odom.y, odometry.base_in_odom.x) == pytest.approx(0.18, abs=0.03)


def test_board_time_takes_the_jitter_out_of_the_stamps() -> None:
    rng, clock = np.random.default_rng(1), BoardClock()
    errors = []
    for i in range(400):
        measured_s = 10.0 + i * CYCLE_S
        delay_s = 0.0125 + float(rng.exponential(0.01))
        errors.append(abs(clock.stamp(i * 60, measured_s + delay_s, 0.0125) - measured_s))
    assert max(errors[50:]) < 0.003


def test_one_damaged_board_time_moves_no_later_stamp() -> None:
    clock = BoardClock()
    for i in range(100):
        board_ms = i * 60 ^ (1 << 8 if i == 50 else 1 << 30 if i == 60 else 0)
        stamp_s = clock.stamp(board_ms, 5.0 + i * CYCLE_S, 0.0)
        assert i in {50, 60} or stamp_s == pytest.approx(5.0 + i * CYCLE_S, abs=1e-6)
    assert clock.restarts == 0


def test_a_board_switched_off_and_on_is_understood() -> None:
    clock = BoardClock()
    for i in range(20):
        clock.stamp(100_000 + i * 60, i * CYCLE_S, 0.0)
    stamps = [clock.stamp(i * 60, 10.0 + i * CYCLE_S, 0.0) for i in range(20)]
    assert clock.restarts == 1
    assert stamps == pytest.approx([10.0 + i * CYCLE_S for i in range(20)])


def test_a_state_without_board_time_is_dated_by_its_arrival() -> None:
    assert BoardClock().stamp(None, 3.0, 0.0125) == pytest.approx(2.9875)


@pytest.mark.parametrize("phase_s", [0.0, 0.21, 0.5, 0.93])
@pytest.mark.parametrize("told", [True, False])
def test_sonar_firings_are_dated(phase_s: float, *, told: bool) -> None:
    """A board fires at known moments; the schedule has to find them, told of CONF_SN or not."""
    config, rng = DriverConfig(), np.random.default_rng(3)
    order, schedule = config.firing_order(), SonarSchedule(config)
    registers, fired = [50] * 16, 0
    if told:
        schedule.restart(phase_s - 0.06)
    errors = []
    for i in range(1000):
        now_s = i * 0.0637  # not in step with the pings, as no real cycle is
        while phase_s + fired * 0.06 + 0.01 <= now_s:
            registers[order[fired % 16]] = int(rng.integers(20, 120))
            fired += 1
        for when_s, ping in schedule.pings(_state(SE2(), sonar=tuple(registers)), now_s):
            nearest = round((when_s - phase_s) / 0.06)
            # A firing put to the wrong sonar is off by a whole number of pings.
            rank_error = (nearest - order.index(ping.sensor) + 8) % 16 - 8
            errors.append(abs(when_s - phase_s - nearest * 0.06) + 0.06 * abs(rank_error))
    settled = errors if told else errors[len(errors) // 4 :]
    assert max(settled) < 0.03
    assert len(errors) == pytest.approx(fired, abs=3 if told else 40)


@given(st.floats(0.0, 10.0), st.floats(0.0, 0.96))
def test_cycles_come_into_step_with_the_echoes(began_s: float, first_s: float) -> None:
    schedule = SonarSchedule(DriverConfig())
    schedule.restart(first_s)
    for _ in range(10):
        wait_s = schedule.next_cycle_s(began_s, CYCLE_S)
        assert 0.8 * CYCLE_S - 1e-9 <= wait_s <= 1.2 * CYCLE_S + 1e-9
        began_s += wait_s
    assert math.remainder(began_s - schedule.phase_s, 0.06) == pytest.approx(math.remainder(0.04, 0.06), abs=1e-6)


def test_a_cycle_that_is_no_multiple_of_a_ping_is_left_alone() -> None:
    assert SonarSchedule(DriverConfig()).next_cycle_s(0.01, 0.05) == 0.05
