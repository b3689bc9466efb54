"""Lock-step waits for everyone, warns once, and names who is missing when it gives up."""

import pytest

from hslam_ros.lock_step import LockStep, LockStepError, Patience
from hslam_ros.stamps import FOREVER_NS


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


def test_a_trailing_answer_may_be_one_cycle_late_and_no_more() -> None:
    """The next cycle waits for the prompt answers to the present one and the trailing ones to the one before."""
    waiting = LockStep(["cmd_vel"], 5.0, 10.0, 60.0, trailing=["atlas"])
    waiting.expect(100, 0.0)
    assert waiting.missing() == ("cmd_vel",)
    waiting.answer("cmd_vel", 100)
    assert waiting.missing() == ()
    waiting.expect(200, 1.0)
    waiting.answer("cmd_vel", 200)
    assert waiting.missing() == ("atlas",)
    waiting.answer("atlas", 100)
    assert waiting.missing() == ()


def test_starting_lasts_until_everybody_has_answered_once() -> None:
    """A trailing node has as long to start as the others."""
    waiting = LockStep(["cmd_vel"], 5.0, 10.0, 60.0, trailing=["atlas"])
    waiting.expect(100, 0.0)
    waiting.answer("cmd_vel", 100)
    waiting.expect(200, 1.0)
    waiting.answer("cmd_vel", 200)
    assert waiting.check(30.0) is Patience.WARN
    waiting.answer("atlas", 200)
    waiting.expect(300, 40.0)
    with pytest.raises(LockStepError, match=r"no answer from cmd_vel$"):
        waiting.check(61.0)


def test_a_suspect_added_when_it_is_late_is_named_if_it_is_behind() -> None:
    """Only the one that has not answered what the others have is at fault."""
    waiting = LockStep(["cmd_vel"], 5.0, 10.0, 10.0, trailing=["atlas"])
    for stamp_ns in (100, 200):
        waiting.expect(stamp_ns, 0.0)
        waiting.answer("cmd_vel", stamp_ns)
    for name in ("gvg", "ekf"):
        waiting.await_also(name)
    waiting.answer("gvg", 200)
    with pytest.raises(LockStepError, match=r"no answer from atlas, ekf$"):
        waiting.check(10.1)


def test_who_answers_for_ever_is_never_waited_for_again_but_a_stray_stamp_is_no_such_answer() -> None:
    for stamp_ns, waited in ((FOREVER_NS, ()), (10**15, ("recorder",))):
        lock = LockStep([], 1.0, 2.0, 3.0, trailing=["recorder"])
        lock.expect(1, 0.0)
        lock.answer("recorder", stamp_ns)
        lock.expect(2, 0.0)
        lock.expect(3, 0.0)
        assert lock.missing() == waited
