"""When an arrival is taken for a known node at once, and what becomes of a branch it was not known to have."""

import pytest
from test_atlas_alignment import drives

from hslam_atlas import mapper
from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.hypothesis import Hypothesis, Sight
from hslam_atlas.questions import Question
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
    best = Hypothesis(known.id, BACK, 20.0, 20.0, 40.0, (None, 0), credible=True)
    monkeypatch.setattr(mapper, "tie", lambda *_, **__: outcome)
    arrival = GvgEvent(3, 3, EventKind.ARRIVAL, None, 0, 10.0)
    is_taken = server.mapper._identified(EdgeEnd(start.id, 0, FORWARD), edge_map, sight, [best], arrival)
    assert is_taken is (outcome is Outcome.CONNECTED)
    assert len(known.branches) == (2 if is_taken else 1)
    if is_taken:
        assert (known.branches[1].seen, known.branches[1].missed) == (1, 2)


def guess(node: int, evidence: float, *, credible: bool = True) -> Hypothesis:
    return Hypothesis(node, BACK, evidence, None, evidence, (0, None), credible)


def taken(guesses: list[Hypothesis], monkeypatch: pytest.MonkeyPatch, questions: tuple[Question, ...] = ()) -> bool:
    """Return whether the best guess is taken, every drive being one that can be entered."""
    server = AtlasServer()
    for _ in range(4):
        server.state.graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0, 1.5])
    server.questions.open += questions
    (edge_map,) = drives(1, 7)
    sight = Sight(NodeKind.MEET_POINT, 1.3, (0.0, 1.5), 0, edge_map)
    monkeypatch.setattr(mapper, "tie", lambda *_, **__: Outcome.CONNECTED)
    arrival = GvgEvent(3, 3, EventKind.ARRIVAL, None, 0, 10.0)
    return server.mapper._identified(EdgeEnd(0, 0, FORWARD), edge_map, sight, guesses, arrival)


CLOSE, MARGIN = AtlasConfig().close_evidence, AtlasConfig().close_margin


@pytest.mark.parametrize(
    ("guesses", "at_once"),
    [
        ([], False),
        ([guess(1, CLOSE)], True),
        ([guess(1, CLOSE - 0.01)], False),
        ([guess(1, 20.0, credible=False)], False),
        ([guess(1, 20.0), guess(2, 20.0 - MARGIN)], True),
        ([guess(1, 20.0), guess(2, 20.01 - MARGIN)], False),
        ([guess(1, CLOSE), guess(2, -20.0)], True),
    ],
)
def test_a_node_is_taken_for_a_known_one_by_evidence_and_a_lead(
    guesses: list[Hypothesis], at_once: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert taken(guesses, monkeypatch) == at_once


@pytest.mark.parametrize(("evidence", "at_once"), [(4.1, True), (3.9, False)])
def test_a_node_likely_one_with_the_best_is_no_rival_to_it(
    evidence: float, at_once: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    doubt = Question(2, 1, FORWARD, evidence)
    assert taken([guess(1, 20.0), guess(2, 19.0)], monkeypatch, (doubt,)) == at_once
