"""Counters that overflow, are set anew or lie."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.se2 import SE2, wrap
from scout_driver.config import DriverConfig
from scout_driver.odometry import Odometry
from scout_driver.protocol.replies import State
from scout_driver.units import METRES_PER_UNIT, RADIANS_PER_UNIT

CYCLE_S = 0.06
SPEED = 100
"""0.254 m/s in wire units."""


def _state(pose: SE2, right: int = 0, left: int = 0) -> State:
    heading = round(pose.theta / RADIANS_PER_UNIT) % 3600
    x, y = round(pose.x / METRES_PER_UNIT), round(pose.y / METRES_PER_UNIT)
    return State(sonar=(50,) * 16, bumper=0, x=x, y=y, heading=heading, right=right, left=left)


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


@pytest.mark.parametrize("turned", [-3.0, -1.0, 0.6, 3.0])
def test_a_turn_that_the_wheels_cannot_make_is_not_believed(turned: float) -> None:
    """A damaged heading beside an undamaged position, with a checksum that held."""
    odometry = Odometry(DriverConfig())
    _drive(odometry, 10)
    before = odometry.base_in_odom
    x = SPEED * METRES_PER_UNIT * CYCLE_S * 10
    assert odometry.update(_state(SE2(x, 0.0, turned), SPEED, SPEED), 10 * CYCLE_S) is None
    assert odometry.base_in_odom == before
    _drive(odometry, 10, start=11)
    assert (odometry.rejected, odometry.jumps) == (1, 0)
    assert odometry.base_in_odom == pytest.approx(SE2(SPEED * METRES_PER_UNIT * CYCLE_S * 20, 0.0, 0.0), abs=0.004)


def test_damaged_states_between_good_ones_are_never_taken_for_new_counters() -> None:
    odometry = Odometry(DriverConfig())
    for i in range(40):
        pose = SE2(30.0, 30.0, 0.0) if i % 4 == 3 else SE2()
        assert (odometry.update(_state(pose), i * CYCLE_S) is None) == (i % 4 == 3)
    assert (odometry.rejected, odometry.jumps) == (10, 0)
    assert odometry.base_in_odom == SE2()


def test_damaged_states_that_disagree_are_never_taken_for_new_counters() -> None:
    odometry = Odometry(DriverConfig())
    odometry.update(_state(SE2()), 0.0)
    for i in range(1, 20):
        assert odometry.update(_state(SE2(10.0 + 20.0 * (i % 3), 0.0, 0.0)), i * CYCLE_S) is None
    assert odometry.jumps == 0


def test_two_states_that_agree_are_not_yet_new_counters_and_three_are() -> None:
    odometry = Odometry(DriverConfig())
    _drive(odometry, 10)
    before, driven = odometry.base_in_odom, odometry.odometer_m
    states = [odometry.update(_state(SE2(-20.0, 5.0, 1.0), SPEED, SPEED), (10 + i) * CYCLE_S) for i in range(3)]
    assert [velocity is not None for velocity in states] == [False, False, True]
    assert (odometry.base_in_odom, odometry.odometer_m, odometry.jumps) == (before, driven, 1)


def test_a_rebase_on_the_way_goes_by_the_mean_speed_and_the_heading() -> None:
    """Position is lost in the exchange; speed grows from 60 to 140 units meanwhile, and the base turns."""
    odometry = Odometry(DriverConfig(rotation_scale=0.9))
    odometry.update(_state(SE2(70.0, 0.0, 0.0), 60, 60), 0.0)
    odometry.expect_rebase()
    assert odometry.update(_state(SE2(0.0, 0.0, 0.3), 140, 140), 0.1) is not None
    way, half = 100 * METRES_PER_UNIT * 0.1, 0.5 * 0.9 * 0.3
    expected = SE2(way * math.cos(half), way * math.sin(half), 2.0 * half)
    assert odometry.base_in_odom == pytest.approx(expected, abs=2e-4)
    assert odometry.odometer_m == pytest.approx(way)
    assert odometry.rebases == 1


def test_a_rebase_explains_no_other_place_than_its_own_and_only_once() -> None:
    odometry = Odometry(DriverConfig())
    odometry.update(_state(SE2(70.0, 0.0, 0.0)), 0.0)
    odometry.expect_rebase()
    assert odometry.update(_state(SE2(40.0, 3.0, 0.0)), CYCLE_S) is None
    assert odometry.update(_state(SE2()), 2 * CYCLE_S) is not None
    for i in range(1, 11):
        assert odometry.update(_state(SE2(0.07 * i, 0.0, 0.0)), (2 + i) * CYCLE_S) is not None
    assert odometry.update(_state(SE2()), 13 * CYCLE_S) is None
    assert (odometry.rebases, odometry.rejected) == (1, 2)


def test_zeroing_forgets_a_rebase_under_way() -> None:
    odometry = Odometry(DriverConfig())
    odometry.update(_state(SE2(70.0, 0.0, 0.0)), 0.0)
    odometry.expect_rebase()
    odometry.zero()
    assert not odometry.needs_rebase()
    assert odometry.update(_state(SE2(70.0, 0.0, 0.0)), CYCLE_S) is not None
    assert odometry.update(_state(SE2()), 2 * CYCLE_S) is None


@pytest.mark.parametrize(
    "place", [SE2(61.0, 0.0, 0.0), SE2(-61.0, 0.0, 0.0), SE2(0.0, 61.0, 0.0), SE2(0.0, -61.0, 0.0)]
)
def test_counters_near_either_end_want_a_rebase(place: SE2) -> None:
    odometry = Odometry(DriverConfig())
    odometry.update(_state(SE2()), 0.0)
    assert not odometry.needs_rebase()
    odometry.zero()
    odometry.update(_state(place), 0.0)
    assert odometry.needs_rebase()


def test_measured_velocity_knows_wheel_order_and_calibration() -> None:
    state = _state(SE2(), 150, 50)
    forward, difference = 100 * METRES_PER_UNIT, 100 * METRES_PER_UNIT
    base_m = DriverConfig().wheel_base_m
    plain = Odometry(DriverConfig(distance_scale=1.1, rotation_scale=0.9)).update(state, 0.0)
    assert plain == pytest.approx((1.1 * forward, 0.9 * difference / base_m))
    swapped = Odometry(DriverConfig(swap_wheels=True)).update(state, 0.0)
    assert swapped == pytest.approx((forward, -difference / base_m))


def test_a_heading_counted_clockwise_is_turned_round() -> None:
    odometry = Odometry(DriverConfig(heading_clockwise=True))
    for i in range(5):
        odometry.update(_state(SE2(0.0, 0.0, -0.1 * i)), 0.1 * i)
    assert odometry.base_in_odom.theta == pytest.approx(0.4, abs=0.002)


def test_the_odometer_counts_both_ways_in_true_metres() -> None:
    odometry = Odometry(DriverConfig(distance_scale=1.1))
    for i, x in enumerate([0.0, 0.1, 0.2, 0.1, 0.0]):
        odometry.update(_state(SE2(x, 0.0, 0.0)), 0.1 * i)
    assert odometry.base_in_odom.x == pytest.approx(0.0, abs=1e-9)
    assert odometry.odometer_m == pytest.approx(1.1 * 0.4, abs=0.005)
