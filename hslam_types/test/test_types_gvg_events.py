"""Events and views of nodes in other frames."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2

ANGLES = st.floats(-math.pi, math.pi)
PLACES = st.floats(-50.0, 50.0)


@given(PLACES, PLACES, ANGLES, PLACES, PLACES, st.lists(ANGLES, min_size=1, max_size=5))
def test_a_moved_view_shows_the_same_node_to_a_moved_robot(
    x: float, y: float, theta: float, node_x: float, node_y: float, bearings: list[float]
) -> None:
    odom_in_map, base_in_odom = SE2(x, y, theta), SE2(1.0, -2.0, 0.7)
    event = GvgEvent(
        3, 5, EventKind.ARRIVAL, NodeView(NodeKind.MEET_POINT, node_x, node_y, 1.2, tuple(bearings)), 0, 4.0
    )
    moved = event.moved(odom_in_map)
    assert event.node is not None
    assert moved.node is not None
    before = base_in_odom.inverse().apply(event.node.x_in_odom, event.node.y_in_odom)
    base_in_map = odom_in_map @ base_in_odom
    assert base_in_map.inverse().apply(moved.node.x_in_odom, moved.node.y_in_odom) == pytest.approx(before, abs=1e-9)
    for old, new in zip(bearings, moved.node.bearings_in_odom, strict=True):
        turned = math.remainder((new - base_in_map.theta) - (old - base_in_odom.theta), math.tau)
        assert turned == pytest.approx(0.0, abs=1e-9)
    assert (moved.sequence, moved.branch, moved.node.clearance_m) == (3, 0, 1.2)


def test_an_event_without_a_node_is_the_same_everywhere() -> None:
    event = GvgEvent(0, 1, EventKind.LOST)
    assert event.moved(SE2(1.0, 2.0, 3.0)) is event
