"""Events and what the EKF level makes of them meet by number, however late either comes."""

from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from edge_walker import EdgeWalker, Step
from hypothesis import given
from hypothesis import strategies as st
from ros_stage import Staged
from test_atlas_node import Pair, walker

from hslam_atlas.inbox import Inbox, Met
from hslam_atlas.server import AtlasServer
from hslam_types.answer import Answer
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind, NodeView
from hslam_types.se2 import SE2

CYCLE_NS = 10**8
VIEW = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, (0.0, 2.0, -2.0))
KINDS = (EventKind.ACCESS, *(EventKind.ARRIVAL, EventKind.DEPARTURE) * 4, EventKind.ARRIVAL)
"""An access, then traversals 2, 4, 6 and 8."""


def event(sequence: int) -> GvgEvent:
    """Return an event of the drive of ``KINDS``, one every ten cycles."""
    return GvgEvent(sequence, 10 * sequence * CYCLE_NS, KINDS[sequence], VIEW, 0)


def map_of(arrival: int) -> EdgeMap:
    return EdgeMap(arrival - 1, arrival, 5.0, np.empty((0, 2)), np.eye(2), (), 0.0, 3.0, SE2(5.0, 0.0, 0.0), 5.0)


def link_of(departure: int) -> FrameLink:
    return FrameLink(departure - 2, departure, SE2(), np.eye(3))


def output_of(sequence: int) -> tuple[EdgeMap | FrameLink, ...]:
    """Return what the EKF level makes of an event of the drive."""
    if sequence < 3:
        return ()
    return (map_of(sequence) if KINDS[sequence] is EventKind.ARRIVAL else link_of(sequence),)


def numbers(met: Met) -> tuple[list[int], list[int], list[int]]:
    """Return the numbers of events, maps and links."""
    return (
        [event.sequence for event in met.events],
        [edge_map.arrival for edge_map in met.edge_maps],
        [link.departure for link in met.links],
    )


def driven(inbox: Inbox, upto: int) -> None:
    """Give an inbox the drive's events before ``upto``, each with its output."""
    for sequence in range(upto):
        met = inbox.take(event(sequence).stamp_ns, (event(sequence),), output_of(sequence), -1)
        assert numbers(met)[0] == [sequence]


def late(inbox: Inbox, cycle: int, *events: GvgEvent, outputs: Any = (), complete_ns: int = -1) -> Any:
    """Take what comes in a cycle after event 3; return the numbers that have met."""
    return numbers(inbox.take(30 * CYCLE_NS + cycle * CYCLE_NS, events, outputs, complete_ns))


@given(delays=st.lists(st.integers(0, 60), min_size=20, max_size=20))
def test_however_late_all_come_out_in_order_and_with_their_own(delays: list[int]) -> None:
    """Each topic keeps its order, as DDS does; events, maps and links are late each for itself."""
    inbox, met = Inbox(waits=True), list[Met]()
    due: dict[int, tuple[list[GvgEvent], list[Any]]] = {}
    newest = {GvgEvent: 0, EdgeMap: 0, FrameLink: 0}
    for sequence in range(len(KINDS)):
        items: tuple[Any, ...] = (event(sequence), *output_of(sequence))
        for item, delay in zip(items, delays[2 * sequence :], strict=False):
            cycle = newest[type(item)] = max(newest[type(item)], 10 * sequence + delay)
            events, outputs = due.setdefault(cycle, ([], []))
            (events if isinstance(item, GvgEvent) else outputs).append(item)
    for cycle in range(max(due) + 1):
        events, outputs = due.get(cycle, ([], []))
        met.append(inbox.take(cycle * CYCLE_NS, tuple(events), tuple(outputs), -1))
    assert [event.sequence for each in met for event in each.events] == list(range(len(KINDS)))
    for each in met:
        come, maps, links = numbers(each)
        assert maps == [n for n in come if n >= 3 and KINDS[n] is EventKind.ARRIVAL]
        assert links == [n for n in come if n >= 3 and KINDS[n] is EventKind.DEPARTURE]
    assert not inbox.awaited(0)


def test_what_is_late_is_told_once_when_awaited_and_once_when_come() -> None:
    inbox = Inbox(waits=True)
    driven(inbox, 3)
    assert late(inbox, 0, event(3)) == ([], [], [])
    assert inbox.news() == ["the edge-map of arrival 3 is late, and waited for"]
    assert late(inbox, 5) == ([], [], [])
    assert inbox.awaited(35 * CYCLE_NS) == "the edge-map of arrival 3 has been awaited for 0.5 s"
    assert (inbox.news(), inbox.late) == ([], 0)
    assert late(inbox, 8, outputs=output_of(3)) == ([3], [3], [])
    assert inbox.news() == ["the edge-map of arrival 3 came 0.8 s after it"]
    assert (inbox.late, inbox.awaited(39 * CYCLE_NS)) == (1, "")
    assert inbox.latest_s == pytest.approx(0.8)
    assert late(inbox, 10, event(4)) == ([], [], [])
    assert late(inbox, 12, outputs=output_of(4)) == ([4], [], [4])
    assert inbox.news()[1:] == ["the link of departure 4 came 0.2 s after it"]
    assert inbox.late == 2
    assert inbox.latest_s == pytest.approx(0.8)


def test_an_event_that_comes_after_its_map_is_met_by_it() -> None:
    inbox = Inbox(waits=True)
    driven(inbox, 3)
    assert late(inbox, 0, outputs=output_of(3)) == ([], [], [])
    assert late(inbox, 7, event(3)) == ([3], [3], [])
    assert inbox.news() == ["the edge-map of arrival 3 came 0.7 s before it"]


def test_no_more_is_waited_for_once_the_ekf_level_has_done_with_the_event() -> None:
    """Not before all it had said by then has come, and been taken: the map may be on its way."""
    inbox = Inbox(waits=True)
    driven(inbox, 3)
    assert late(inbox, 0, event(3), complete_ns=30 * CYCLE_NS) == ([], [], [])
    inbox.hear(Answer(31 * CYCLE_NS, 0, finished=False, next_event=3))
    inbox.hear(Answer(32 * CYCLE_NS, 0, finished=False, next_event=4))
    assert late(inbox, 3, complete_ns=31 * CYCLE_NS) == ([], [], [])
    assert late(inbox, 1, complete_ns=32 * CYCLE_NS) == ([], [], [])
    assert late(inbox, 4, complete_ns=32 * CYCLE_NS) == ([3], [], [])
    # After an arrival without a map no link is to come.
    assert late(inbox, 10, event(4)) == ([4], [], [])


def test_an_answer_from_before_the_event_says_nothing_of_it() -> None:
    """As where the GVG level has begun to count anew, and the EKF level does not know it yet."""
    inbox = Inbox(waits=True)
    driven(inbox, 3)
    inbox.hear(Answer(29 * CYCLE_NS, 0, finished=False, next_event=9))
    assert late(inbox, 0, event(3), complete_ns=31 * CYCLE_NS) == ([], [], [])


def test_an_ekf_level_that_was_started_again_owes_nothing() -> None:
    inbox = Inbox(waits=True)
    driven(inbox, 3)
    inbox.hear(Answer(29 * CYCLE_NS, 0, finished=False, next_event=3))
    assert late(inbox, 0, event(3), complete_ns=30 * CYCLE_NS) == ([], [], [])
    inbox.hear(Answer(31 * CYCLE_NS, 0, finished=False, next_event=3))
    assert late(inbox, 2, complete_ns=31 * CYCLE_NS) == ([], [], [])
    inbox.hear(Answer(32 * CYCLE_NS, 0, finished=False, next_event=0))
    assert late(inbox, 3, complete_ns=30 * CYCLE_NS) == ([3], [], [])
    assert late(inbox, 4, outputs=output_of(3)) == ([], [], [])
    assert inbox.news()[-1] == "what belongs to arrival 3 came too late, and is left out"


def test_a_departure_after_another_has_no_link() -> None:
    """What was under way has ended without a word, and with it the filter that would have made the link."""
    inbox = Inbox(waits=True)
    driven(inbox, 4)
    again = GvgEvent(5, 50 * CYCLE_NS, EventKind.DEPARTURE, VIEW, 1)
    assert late(inbox, 20, event(4), again, outputs=output_of(4)) == ([4, 5], [], [4])


def test_a_later_map_shows_that_an_earlier_one_will_not_come() -> None:
    """As from recordings whose statuses do not tell which events the EKF level has done with."""
    inbox = Inbox(waits=True)
    driven(inbox, 3)
    assert late(inbox, 0, event(3), event(4), event(5)) == ([], [], [])
    assert late(inbox, 1, outputs=(map_of(5),)) == ([3, 4, 5], [5], [])


def test_who_begins_anew_forgets_numbers() -> None:
    inbox = Inbox(waits=True)
    driven(inbox, 3)
    assert late(inbox, 0, event(3), outputs=(map_of(7),)) == ([3], [], [])
    inbox.clear()
    assert numbers(inbox.take(0, (event(0), event(1), event(2)), (), -1)) == ([0, 1, 2], [], [])
    assert late(inbox, 0, event(3)) == ([], [], [])


def test_in_lock_step_nothing_waits() -> None:
    inbox = Inbox(waits=False)
    assert late(inbox, 0, event(0), event(1), event(2), event(3)) == ([0, 1, 2, 3], [], [])


def driven_freely(pair: Pair, base: EdgeWalker) -> Step:
    """Map a way to a first node and the departure from it, running free; return the arrival that follows."""
    for step in base.follow(GvgGoal(GoalKind.ACCESS)):
        pair.cycle(step.stamp_ns, step)
        pass_time(pair, step.stamp_ns)
    departure, arrival = base.follow(GvgGoal(GoalKind.TRACE, branch=0))
    pair.cycle(departure.stamp_ns, departure)
    pass_time(pair, departure.stamp_ns)
    return arrival


def pass_time(pair: Pair, stamp_ns: int) -> None:
    """Let gvg answer cycles for half a second, which is longer than the hold-back, and wait for the atlas's answers."""
    for later in (1, 2):
        pair.rest.say_gvg(stamp_ns + later * 250_000_000)
    pair.spin_until(lambda: pair.answered(stamp_ns + 250_000_000))


def test_running_freely_a_map_later_than_the_hold_back_makes_its_edge(staged: Staged) -> None:
    pair = staged(Pair, mission="none", lockstep=False, hold_back_s=0.2)
    told: list[DiagnosticArray] = []
    pair.rest.create_subscription(DiagnosticArray, "/diagnostics", told.append, 10)
    arrival = driven_freely(pair, walker())
    graph = pair.atlas._server.state.graph
    pair.rest.say_gvg(arrival.stamp_ns, arrival.events)
    pass_time(pair, arrival.stamp_ns)
    assert (len(graph.nodes), len(graph.edges)) == (1, 0)
    awaited = f"the edge-map of arrival {arrival.events[0].sequence} has been awaited for"
    assert awaited in pair.rest.statuses[-1].detail

    def about_maps() -> list[DiagnosticStatus]:
        return [status for array in told for status in array.status if status.name == "atlas: edge-maps"]

    pair.spin_until(lambda: bool(about_maps()) and awaited in about_maps()[-1].message)
    assert about_maps()[-1].level == DiagnosticStatus.WARN
    pair.rest.say_ekf(arrival.stamp_ns + 10**9, arrival, next_event=arrival.events[0].sequence + 1)
    pass_time(pair, arrival.stamp_ns + 10**9)
    assert (len(graph.nodes), len(graph.edges)) == (2, 1)
    assert awaited not in pair.rest.statuses[-1].detail
    pair.spin_until(lambda: {value.key: value.value for value in about_maps()[-1].values}["late"] == "1")


def test_running_freely_late_maps_and_events_make_the_atlas_of_the_plain_server(staged: Staged) -> None:
    """The robot goes on while they are under way; all of the EKF level's words come when the drive has ended."""
    pair = staged(Pair, mission="none", lockstep=False, hold_back_s=0.2)
    plain, base, steps = AtlasServer(), walker(), list[Step]()
    goal = plain.step((), (), ()).goal
    for _ in range(4):
        assert goal is not None
        for step in base.follow(goal):
            steps.append(step)
            goal = plain.step(step.events, step.edge_maps, step.links).goal or goal
    for step in steps:
        pair.rest.say_gvg(step.stamp_ns, step.events)
        pass_time(pair, step.stamp_ns)
    last_ns = steps[-1].stamp_ns
    for step in steps:
        pair.rest.say_ekf(last_ns + 10**9, step, next_event=step.events[-1].sequence + 1)
    pass_time(pair, last_ns + 10**9)
    server = pair.atlas._server
    server.save()
    plain.save()
    assert list(server.store.dump()) == list(plain.store.dump())


def test_a_map_that_will_not_come_leaves_the_arrival_a_node_of_its_own(staged: Staged) -> None:
    pair = staged(Pair, mission="none", lockstep=False, hold_back_s=0.2)
    arrival = driven_freely(pair, walker())
    graph = pair.atlas._server.state.graph
    pair.rest.say_gvg(arrival.stamp_ns, arrival.events)
    pass_time(pair, arrival.stamp_ns)
    assert len(graph.nodes) == 1
    pair.rest.say_ekf(arrival.stamp_ns + 10**9, None, next_event=arrival.events[0].sequence + 1)
    pass_time(pair, arrival.stamp_ns + 10**9)
    assert (len(graph.nodes), len(graph.edges)) == (2, 0)
