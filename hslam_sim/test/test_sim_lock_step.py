"""Lock-step waits for everyone, warns once, and names who is missing when it gives up."""

import pytest

from hslam_sim.lock_step import LockStep, LockStepError, Patience


def test_a_cycle_is_answered_when_everybody_has_answered_it() -> None:
    """Old answers do not count, newer ones do, and the order of answers is free."""
    waiting = LockStep(["gvg", "ekf"], 5.0, 10.0, 60.0)
    waiting.expect(100, 0.0)
    assert waiting.missing() == ("gvg", "ekf")
    waiting.answer("ekf", 100)
    waiting.answer("gvg", 99)
    assert waiting.missing() == ("gvg",)
    waiting.answer("gvg", 101)
    waiting.answer("gvg", 100)
    assert waiting.missing() == ()
    waiting.expect(102, 1.0)
    assert waiting.missing() == ("gvg", "ekf")


def test_a_late_answer_is_reported_once_and_then_ends_the_run() -> None:
    """The warning comes after the first limit, the error after the second, both by name."""
    waiting = LockStep(["gvg", "ekf"], 5.0, 10.0, 60.0)
    waiting.expect(100, 0.0)
    waiting.answer("gvg", 100)
    waiting.answer("ekf", 100)
    assert waiting.check(1000.0) is Patience.WAIT
    waiting.expect(200, 1000.0)
    waiting.answer("gvg", 200)
    assert waiting.check(1004.9) is Patience.WAIT
    assert waiting.check(1005.1) is Patience.WARN
    assert waiting.check(1009.0) is Patience.WAIT
    with pytest.raises(LockStepError, match=r"no answer from ekf$"):
        waiting.check(1010.1)


def test_the_first_cycle_may_take_as_long_as_nodes_need_to_start() -> None:
    """Before anything has answered, the start-up limit holds."""
    waiting = LockStep(["gvg"], 5.0, 10.0, 60.0)
    waiting.expect(100, 0.0)
    assert waiting.check(20.0) is Patience.WARN
    with pytest.raises(LockStepError, match="gvg"):
        waiting.check(60.1)
