"""Cycles come out complete and in order, however the messages of several topics interleave."""

from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_ros.continuity import Continuity
from hslam_ros.step_order import TIME, Cycle, StepOrder
from hslam_types.errors import MessageError
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample


def test_a_cycle_waits_for_an_implicit_stream() -> None:
    order = StepOrder(implicit=["sonar"])
    order.tick(10, "odom")
    assert not list(order.ready())
    order.put("sonar", 10, "sweep")
    (cycle,) = order.ready()
    assert (cycle.stamp_ns, cycle.clock, cycle.inputs) == (10, "odom", {"sonar": ("sweep",)})


def test_a_cycle_waits_for_every_promised_message() -> None:
    order = StepOrder(promised={"events": 1000})
    order.tick(10)
    order.promise("events", 10, 2)
    order.put("events", 10, "arrival")
    assert not list(order.ready())
    order.put("events", 10, "departure")
    (cycle,) = order.ready()
    assert cycle.inputs == {"events": ("arrival", "departure")}


def test_messages_of_a_later_cycle_stay_behind() -> None:
    order = StepOrder(implicit=["sonar"])
    order.put("sonar", 10, "early")
    order.put("sonar", 20, "late")
    order.tick(10)
    (cycle,) = order.ready()
    assert cycle.inputs == {"sonar": ("early",)}


def test_running_free_it_waits_no_longer_than_the_hold_back() -> None:
    order = StepOrder(promised={"landmarks": 16}, hold_ns=5)
    order.tick(10)
    order.tick(14)
    assert not list(order.ready())
    order.tick(15)
    assert [cycle.stamp_ns for cycle in order.ready()] == [10]


@given(st.lists(st.integers(0, 3), min_size=1, max_size=8), st.randoms(use_true_random=False))
def test_any_interleaving_gives_the_same_cycles(events_per_cycle: list[int], random: Random) -> None:
    """Each topic keeps its own order, as DDS does; the topics interleave at random."""
    clock = [("tick", 10 * i, f"odom{i}") for i in range(len(events_per_cycle))]
    events = [("event", 10 * i, f"event{i}.{k}") for i, n in enumerate(events_per_cycle) for k in range(n)]
    totals = [sum(events_per_cycle[: i + 1]) for i in range(len(events_per_cycle))]
    promises = [("promise", 10 * i, total) for i, total in enumerate(totals)]
    order = StepOrder(promised={"events": 1000})
    seen: list[Cycle] = []
    topics: list[list[tuple[str, int, Any]]] = [[*clock], [*events], [*promises]]
    while any(topics):
        kind, stamp_ns, item = random.choice([topic for topic in topics if topic]).pop(0)
        if kind == "tick":
            order.tick(stamp_ns, item)
        elif kind == "event":
            order.put("events", stamp_ns, item)
        else:
            order.promise("events", stamp_ns, item)
        seen += order.ready()
    expected = [tuple(f"event{i}.{k}" for k in range(n)) for i, n in enumerate(events_per_cycle)]
    assert [cycle.inputs["events"] for cycle in seen] == expected
    assert [cycle.clock for cycle in seen] == [f"odom{i}" for i in range(len(expected))]


def test_a_refused_message_counts_as_come() -> None:
    order = StepOrder(implicit=["sonar"], promised={"events": 1000})
    order.tick(10, "odom")
    order.promise("events", 10, 2)
    order.put("events", 10, "arrival")
    order.miss("events", None)
    assert not list(order.ready())
    order.miss("sonar", 10)
    (cycle,) = order.ready()
    assert cycle.inputs == {"sonar": (), "events": ("arrival",)}


def test_a_refused_clock_message_is_a_cycle_to_answer_whose_inputs_wait_for_the_next() -> None:
    order = StepOrder(implicit=["sonar"])
    order.tick(10, "odom")
    order.put("sonar", 10, "first")
    order.put("sonar", 20, "second")
    order.skip(20)
    assert [(cycle.stamp_ns, cycle.skipped) for cycle in order.ready()] == [(10, False), (20, True)]
    order.tick(30, "odom")
    order.put("sonar", 30, "third")
    (cycle,) = order.ready()
    assert (cycle.clock, cycle.skipped, cycle.inputs) == ("odom", False, {"sonar": ("second", "third")})


def test_the_stamp_of_a_refused_message_is_believed_only_where_it_is_due() -> None:
    order = StepOrder(implicit=["sonar"])
    order.tick(10, "odom")
    order.put("sonar", 10, "sweep")
    assert len(list(order.ready())) == 1
    for stamp_ns in (None, 10, 5, 2**61):
        order.skip(stamp_ns)
        order.miss("sonar", stamp_ns)
    order.tick(20, "odom")
    assert not list(order.ready())


def test_a_message_that_repeats_the_stamp_of_the_clock_is_refused() -> None:
    order = StepOrder()
    order.tick(10, "odom")
    with pytest.raises(MessageError, match="that of the message before"):
        order.tick(10, "odom")
    assert len(list(order.ready())) == 1


def test_stamps_that_go_back_begin_anew_and_are_told_once() -> None:
    order = StepOrder(implicit=["sonar"])
    for stamp_ns in (1_000, 2_000):
        order.tick(stamp_ns * 10**9)
        order.put("sonar", stamp_ns * 10**9, stamp_ns)
    assert [dict(cycle.anew) for cycle in order.ready()] == [{}, {}]
    for stamp_ns in (3, 4):
        order.tick(stamp_ns * 10**9)
        order.put("sonar", stamp_ns * 10**9, stamp_ns)
    again, after = order.ready()
    assert again.anew == {TIME: "stamps went back from 2000.00 s to 3.00 s"}
    assert (again.inputs, dict(after.anew)) == ({"sonar": (3,)}, {})


def test_a_count_that_goes_down_tells_that_its_source_was_started_again() -> None:
    order = StepOrder(promised={"events": 10})
    order.promise("events", 10, 0)
    order.tick(10)
    order.put("events", 20, "old")
    order.promise("events", 20, 1)
    order.tick(20)
    assert [cycle.inputs["events"] for cycle in order.ready()] == [(), ("old",)]
    order.promise("events", 30, 0)
    order.tick(30)
    (cycle,) = order.ready()
    assert list(cycle.anew) == ["events"]
    order.promise("events", 40, 1)
    order.tick(40)
    assert not list(order.ready())
    order.put("events", 40, "new")
    (cycle,) = order.ready()
    assert (cycle.inputs["events"], dict(cycle.anew)) == (("new",), {})


@pytest.mark.parametrize(("x", "stamp_ns", "jumped"), [(0.9, 1, False), (1.1, 1, True), (3.9, 10**9, False)])
def test_a_pose_that_jumps_is_told_unless_the_base_may_have_driven(x: float, stamp_ns: int, *, jumped: bool) -> None:
    continuity = Continuity()
    assert not continuity.broken_by(OdometrySample(0, SE2(100.0, 0.0, 0.0)))
    assert bool(continuity.broken_by(OdometrySample(stamp_ns, SE2(100.0, x, 1.0)))) is jumped
    assert not continuity.broken_by(OdometrySample(stamp_ns, SE2(100.0, x, 1.0)))
