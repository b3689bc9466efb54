"""The base's clock set against the computer's: jitter, damage, drift, a board switched off and on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scout_driver.board_clock import BoardClock

CYCLE_S = 0.06


def test_board_time_takes_the_jitter_out_of_the_stamps() -> None:
    rng, clock = np.random.default_rng(1), BoardClock()
    errors = []
    for i in range(400):
        measured_s = 10.0 + i * CYCLE_S
        delay_s = 0.0125 + float(rng.exponential(0.01))
        errors.append(abs(clock.stamp(i * 60, measured_s + delay_s, 0.0125) - measured_s))
    assert max(errors[50:]) < 0.003


@given(st.integers(2, 99), st.integers(0, 31))
def test_one_damaged_board_time_moves_no_later_stamp(damaged: int, bit: int) -> None:
    """Later or earlier than it was, by a millisecond or by weeks."""
    clock = BoardClock()
    for i in range(100):
        board_ms = i * 60 ^ (1 << bit if i == damaged else 0)
        stamp_s = clock.stamp(board_ms, 5.0 + i * CYCLE_S, 0.0)
        assert i == damaged or stamp_s == pytest.approx(5.0 + i * CYCLE_S, abs=1e-6)
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
