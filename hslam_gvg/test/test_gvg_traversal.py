"""Whatever ends a traversal is announced, and events are counted without gaps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_gvg.driving.traversal import Leg, Traversal
from hslam_types.gvg_events import EventKind, NodeKind, NodeView

NODE = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, (0.0, 2.0, -2.0))
ACTS = ("access", "depart", "arrive", "give_up", "lose")


def act(traversal: Traversal, name: str) -> None:
    """Let one thing happen; nobody arrives who is not under way."""
    if name == "depart":
        traversal.depart(Leg(NODE, 1, (np.zeros((2, 3)),) * 3))
    elif name == "arrive":
        if traversal.leg is not None:
            traversal.arrive(NODE, 2)
    else:
        getattr(traversal, name)()


@given(st.lists(st.sampled_from(ACTS), max_size=30))
def test_every_traversal_begun_is_ended_before_the_next(names: list[str]) -> None:
    traversal, said = Traversal(), []
    for step, name in enumerate(names):
        traversal.begin_step(step)
        act(traversal, name)
        said += traversal.events
    assert [event.sequence for event in said] == list(range(len(said)))
    underway = False
    for event in said:
        begins = event.kind in (EventKind.ACCESS, EventKind.DEPARTURE)
        assert not (begins and underway)
        if event.kind is EventKind.ARRIVAL:
            assert underway
        underway = begins
    assert (traversal.leg is not None) is underway


def test_the_length_is_of_the_edge_alone_and_told_at_the_arrival() -> None:
    traversal = Traversal()
    traversal.begin_step(0)
    traversal.access()
    traversal.advance(1.0, 0.0, 1.0)
    traversal.advance(1.5, 0.0, 0.0)  # on the way back off something: not along the edge
    traversal.begin_step(1)
    traversal.arrive(NODE, 0)
    assert traversal.events[0].path_length_m == 1.0
    traversal.advance(9.0, 0.0, 1.0)
    assert traversal.length_m == 1.0


def test_the_trail_leads_back_from_the_newest_place() -> None:
    traversal = Traversal()
    traversal.access()
    for x in np.arange(0.0, 2.0, 0.05):
        traversal.advance(float(x), 0.0, 0.05)
    back = traversal.back()
    assert back[0, 0] > 1.85
    assert back[-1, 0] == 0.0
    assert (np.diff(back[:, 0]) < 0.0).all()
    assert len(traversal.back(0.8)) == 10


def test_a_node_passed_is_where_the_edge_ends_and_the_way_back_to_it_is_no_part_of_it() -> None:
    traversal = Traversal()
    traversal.access()
    for x in np.arange(0.0, 3.01, 0.1):
        traversal.advance(float(x), 0.0, 0.0 if x == 0.0 else 0.1)
    traversal.rewind(2.0, 0.3, 2.5)
    assert traversal.length_m == pytest.approx(2.0)
    for x in np.arange(3.0, 2.0, -0.1):
        traversal.advance(float(x), 0.0, 0.0)
    assert traversal.back()[0, :2] == pytest.approx((2.0, 0.0))
    assert traversal.length_m == pytest.approx(2.0)
    traversal.rewind(0.0, 0.0, 1.0)  # a place passed longer ago than that is not looked for
    assert traversal.length_m == pytest.approx(1.0, abs=0.15)
