"""The order, portions and pace of a replay, without ROS."""

import random
import struct

import pytest

from hslam_bags.answers import Answers, NoAnswerError
from hslam_bags.cycles import in_portions, in_stamp_order, stamp_of
from hslam_bags.pace import Pace
from hslam_bags.promises import Promises
from hslam_bags.recording_clock import RecordingClock, leading_stamp_ns
from hslam_bags.stored import StoredMessage, in_time_order
from hslam_bags.topic_choice import TopicChoice, names
from hslam_types.errors import ConfigurationError

SECOND = 10**9


def stamped(stamp_ns: int, *, big: bool = False) -> bytes:
    """Return CDR bytes that begin with a stamp."""
    order = ">" if big else "<"
    return bytes([0, 0 if big else 1, 0, 0]) + struct.pack(order + "iI", stamp_ns // SECOND, stamp_ns % SECOND)


def message(topic: str, stamp_ns: int, log_ns: int) -> StoredMessage:
    return StoredMessage(topic, "any/msg/Type", stamped(stamp_ns), log_ns, log_ns)


def test_messages_go_back_to_the_order_of_their_stamps() -> None:
    rng = random.Random(3)
    stamps = [index * 10**8 for index in range(200)]
    late = sorted(
        (message("/odom", stamp, stamp + rng.randrange(10**9)) for stamp in stamps), key=lambda entry: entry.log_ns
    )
    assert [entry.log_ns for entry in late] != sorted(entry.log_ns for entry in late) or late != sorted(late)
    assert [time_ns for time_ns, _ in in_stamp_order(late, stamp_of)] == stamps


def test_equal_times_keep_the_order_of_recording() -> None:
    same = [message(f"/t{index}", SECOND, SECOND) for index in range(50)]
    assert [entry for _, entry in in_stamp_order(same, stamp_of)] == same
    pieces = [(SECOND, lambda index=index: iter(same[index : index + 10])) for index in range(0, 50, 10)]
    assert list(in_time_order(pieces)) == same


def test_a_stamp_of_another_time_is_not_used() -> None:
    assert stamp_of(message("/map", 0, 100 * SECOND)) == 100 * SECOND
    assert stamp_of(message("/odom", 99 * SECOND, 100 * SECOND)) == 99 * SECOND
    assert stamp_of(StoredMessage("/short", "any/msg/Type", b"\0\1\0\0", 7, 7)) == 7


def test_a_cycle_holds_everything_since_the_one_before() -> None:
    log = [("/event", 1), ("/odom", 2), ("/sonar", 2), ("/event", 3), ("/odom", 4), ("/event", 5)]
    timed = [(time_ns, message(topic, time_ns, time_ns)) for topic, time_ns in log]
    portions = [
        (portion.time_ns, [entry.topic for entry in portion.messages], portion.complete)
        for portion in in_portions(timed, "/odom")
    ]
    assert portions == [
        (2, ["/event", "/odom", "/sonar"], True),
        (4, ["/event", "/odom"], True),
        (5, ["/event"], False),
    ]
    assert [portion.time_ns for portion in in_portions(timed, None)] == [1, 2, 3, 4, 5]


def test_pace_passes_rests_and_jumps() -> None:
    pace = Pace(100, rate=2.0)
    assert (pace.bag_ns(5), pace.running) == (100, False)
    pace.run(10)
    assert pace.bag_ns(15) == 110
    pace.rest(20)
    assert (pace.bag_ns(1000), pace.running) == (120, False)
    pace.run(2000)
    assert pace.bag_ns(2001) == 122
    pace.jump(500, 2001)
    assert pace.bag_ns(2002) == 502


def test_answers_name_who_is_missing() -> None:
    answers = Answers(["ekf", "atlas"], start_s=60.0, patience_s=10.0)
    assert answers.missing() == ()
    answers.expect(5, now_s=0.0)
    answers.take("ekf", 5)
    answers.take("ekf", 3)
    assert answers.missing() == ("atlas",)
    answers.check(59.0)
    answers.take("atlas", 7)
    assert answers.missing() == ()
    answers.check(1000.0)
    answers.expect(8, now_s=1000.0)
    with pytest.raises(NoAnswerError, match=r"no answer from ekf, atlas to the cycle at 0\.00 s after 11 s"):
        answers.check(1011.0)


def test_promises_count_for_sources_that_are_not_live() -> None:
    promises = Promises(live=["ekf"])
    assert promises.sources == ("sim", "gvg")
    assert promises.status_topics == {"/sim/status", "/gvg/status"}
    for topic in ("/landmarks", "/gvg/events", "/gvg/events", "/ekf/edge_maps", "/odom"):
        promises.count(topic)
    assert (promises.outputs("sim"), promises.outputs("gvg")) == (1, 2)


def test_topics_are_chosen_by_name_or_expression() -> None:
    choice = TopicChoice(("odom", "/gvg/.*"), ("/gvg/local_map",))
    chosen = [name for name in ("/odom", "/odom2", "/gvg/events", "/gvg/local_map", "/a/odom") if name in choice]
    assert chosen == ["/odom", "/gvg/events"]
    assert "/explore/_action/feedback" not in TopicChoice()
    assert "/explore/_action/feedback" in TopicChoice(hidden=True)
    assert names(" a, /b ,,") == ("a", "/b")
    with pytest.raises(ConfigurationError, match=r"'\*' is neither a topic nor a regular expression"):
        TopicChoice(("*",))


@pytest.mark.parametrize("big", [False, True])
def test_leading_stamp_in_either_byte_order(*, big: bool) -> None:
    assert leading_stamp_ns(stamped(3 * SECOND + 7, big=big)) == 3 * SECOND + 7
    assert leading_stamp_ns(b"\0\1\0\0\0") == -1


def test_recording_time_is_the_stamp_near_the_clock_and_the_newest_otherwise() -> None:
    times = RecordingClock()
    assert RecordingClock().newest_ns is None
    assert times.stamp_ns(stamped(1_700_000_000 * SECOND)) == 1_700_000_000 * SECOND  # no clock yet: taken as it is
    assert times.tick(stamped(5 * SECOND)) == 5 * SECOND
    assert times.newest_ns == 5 * SECOND  # the clock decides
    assert times.stamp_ns(stamped(6 * SECOND)) == 6 * SECOND
    assert times.newest_ns == 6 * SECOND
    assert times.stamp_ns(stamped(1_700_000_000 * SECOND)) == 6 * SECOND
    assert times.tick(stamped(100 * SECOND)) == 100 * SECOND
    assert times.stamp_ns(stamped(0)) == 100 * SECOND
