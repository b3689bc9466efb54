"""An arrival as the atlas reads it."""

import math

import pytest
from test_atlas_alignment import drives

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.hypothesis import Sight
from hslam_atlas.sighting import observe, sight_of
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2, wrap


def test_an_unknown_branch_ties_the_view_by_the_first() -> None:
    """As the EKF level puts it into the map: the first branch leaves along ``arrival_heading``."""
    (edge_map,) = drives(1, 7)
    view = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.3, (0.3, 2.5, -1.0))
    known, unknown = (sight_of(GvgEvent(9, 0, EventKind.ARRIVAL, view, branch, 10.0), edge_map) for branch in (0, -1))
    assert unknown.bearings == known.bearings
    assert unknown.bearings[0] == pytest.approx(wrap(edge_map.arrival_heading - math.pi))
    assert unknown.come_along == -1


def test_visits_in_a_row_that_do_not_show_a_branch_are_counted() -> None:
    node = AtlasGraph().add_node(NodeKind.MEET_POINT, 1.3, [0.0, 1.5, 3.0])
    for bearings, unseen in (((0.0, 1.5), 1), ((0.0, 1.5), 2), ((0.1, 1.5, 3.1), 0), ((0.0, 1.5), 1)):
        observe(node, Sight(NodeKind.MEET_POINT, 1.3, bearings, 0, None), SE2(), AtlasConfig())
        assert [branch.unseen for branch in node.branches.values()] == [0, 0, unseen]
