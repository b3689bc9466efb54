"""An arrival as the atlas reads it."""

import math

import pytest
from test_atlas_alignment import drives

from hslam_atlas.sighting import sight_of
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import wrap


def test_an_unknown_branch_ties_the_view_by_the_first() -> None:
    """As the EKF level puts it into the map: the first branch leaves along ``arrival_heading``."""
    (edge_map,) = drives(1, 7)
    view = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.3, (0.3, 2.5, -1.0))
    known, unknown = (sight_of(GvgEvent(9, 0, EventKind.ARRIVAL, view, branch, 10.0), edge_map) for branch in (0, -1))
    assert unknown.bearings == known.bearings
    assert unknown.bearings[0] == pytest.approx(wrap(edge_map.arrival_heading - math.pi))
    assert unknown.come_along == -1
