"""A node identified by an arrival along a branch it was not known to have."""

import pytest
from test_atlas_alignment import drives

from hslam_atlas import mapper
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.hypothesis import Hypothesis, Sight
from hslam_atlas.server import AtlasServer
from hslam_atlas.tie import Outcome
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind
from hslam_types.se2 import SE2

FORWARD = UncertainPose.exact(SE2())
BACK = UncertainPose.diagonal(SE2(), 0.01, 0.01)


@pytest.mark.parametrize("outcome", [Outcome.CONTRADICTED, Outcome.CONNECTED])
def test_the_branch_is_added_only_if_the_drive_is_entered(outcome: Outcome, monkeypatch: pytest.MonkeyPatch) -> None:
    server = AtlasServer()
    graph = server.state.graph
    start = graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0])
    known = graph.add_node(NodeKind.MEET_POINT, 1.3, [1.5])
    known.visits += [(1, 1), (2, 2)]
    (edge_map,) = drives(1, 7)
    sight = Sight(NodeKind.MEET_POINT, 1.3, (0.0, 1.5), 0, edge_map)
    guess = Hypothesis(known.id, BACK, 20.0, 20.0, 40.0, (None, 0), credible=True)
    monkeypatch.setattr(mapper, "tie", lambda *_: outcome)
    arrival = GvgEvent(3, 3, EventKind.ARRIVAL, None, 0, 10.0)
    taken = server.mapper._identified(EdgeEnd(start.id, 0, FORWARD), edge_map, sight, [guess], arrival)
    assert taken is (outcome is Outcome.CONNECTED)
    assert len(known.branches) == (2 if taken else 1)
    if taken:
        assert (known.branches[1].seen, known.branches[1].missed) == (1, 2)
