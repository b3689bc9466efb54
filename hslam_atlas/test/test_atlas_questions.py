"""Known answers about open questions: when one is closed, and what becomes of the others."""

import math

import pytest
from scripted_level import EXACT, edge_map, row

from hslam_atlas import questions as module
from hslam_atlas.config import AtlasConfig
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.questions import Question, Questions, _weighed
from hslam_atlas.state import AtlasState, Merged
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

CLOSE, MARGIN = AtlasConfig().close_evidence, AtlasConfig().close_margin
TURNED = UncertainPose.exact(SE2(1.0, 2.0, 0.5))


def asked(*questions: tuple[int, int, float]) -> Questions:
    """Return open questions (node, other, evidence)."""
    found = Questions(LookAlikes(1e-4))
    for node, other, evidence in questions:
        found.add(Question(node, other, EXACT, evidence))
    return found


def answer(questions: Questions) -> tuple[int, int] | None:
    closed = questions._stands_alone(row())
    return None if closed is None else (closed.node, closed.other)


@pytest.mark.parametrize(("evidence", "closed"), [(CLOSE, True), (CLOSE - 0.01, False)])
def test_an_answer_needs_enough_evidence(evidence: float, closed: bool) -> None:
    assert (answer(asked((5, 1, evidence))) is not None) == closed


@pytest.mark.parametrize(("lead", "closed"), [(MARGIN, True), (MARGIN - 0.01, False)])
def test_an_answer_needs_a_clear_lead_over_every_rival(lead: float, closed: bool) -> None:
    assert (answer(asked((5, 1, 20.0), (5, 2, 20.0 - lead), (5, 3, 0.0))) is not None) == closed


@pytest.mark.parametrize(("evidence", "closed"), [(4.1, True), (3.9, False)])
def test_two_nodes_that_are_likely_one_themselves_are_no_rivals(evidence: float, closed: bool) -> None:
    questions = asked((5, 1, 20.0), (5, 2, 19.0), (2, 1, evidence))
    assert (answer(questions) == (5, 1)) == closed


def test_an_answer_to_another_question_is_no_rival() -> None:
    assert answer(asked((5, 1, 20.0), (6, 2, 19.0))) == (5, 1)
    assert answer(asked((5, 1, 20.0), (6, 1, 19.0))) == (5, 1)


def test_the_likeliest_answer_that_stands_alone_is_closed_though_a_likelier_one_has_rivals() -> None:
    assert answer(asked((5, 1, 20.0), (5, 2, 19.0), (6, 3, 12.0))) == (6, 3)


def test_questions_about_a_node_come_likeliest_first() -> None:
    assert [q.other for q in asked((5, 1, 1.0), (5, 2, 3.0), (6, 4, 9.0), (5, 3, 2.0)).of(5)] == [2, 3, 1]


def test_evidence_adds_place_and_maps_by_what_these_are_worth() -> None:
    question = Question(5, 1, EXACT, 3.0, (2.0, -4.0))
    alike = LookAlikes(1e-4)
    assert Questions(alike).evidence(question) == pytest.approx(3.0 + alike.joint((2.0, -4.0)))


def test_a_question_follows_a_node_that_has_become_part_of_another() -> None:
    """Where the one asked about lies in the other does not change with the names."""
    questions = asked()
    questions.add(Question(7, 4, UncertainPose.exact(SE2(0.3, 0.0, 0.1)), 1.0))
    questions.follow(Merged(7, 5, TURNED, {}))
    (question,) = questions.open
    assert (question.node, question.other) == (5, 4)
    assert question.node_in_other.pose == pytest.approx(SE2(0.3, 0.0, 0.1) @ TURNED.pose.inverse())
    questions.follow(Merged(4, 2, TURNED, {}))
    (question,) = questions.open
    assert (question.node, question.other) == (5, 2)
    assert question.node_in_other.pose == pytest.approx(TURNED.pose @ SE2(0.3, 0.0, 0.1) @ TURNED.pose.inverse())


def test_the_younger_node_is_the_one_asked_about() -> None:
    questions = asked()
    questions.add(Question(7, 4, TURNED, 1.0))
    questions.follow(Merged(7, 1, EXACT, {}))
    (question,) = questions.open
    assert (question.node, question.other) == (4, 1)
    assert question.node_in_other.pose == pytest.approx(TURNED.pose.inverse())


def test_of_two_questions_that_become_one_the_likelier_is_kept_and_one_about_a_single_node_is_answered() -> None:
    questions = asked((7, 4, 2.0), (7, 3, 6.0), (7, 5, 1.0), (4, 3, 1.0))
    questions.follow(Merged(4, 3, EXACT, {}))
    assert [(q.node, q.other, q.place_evidence) for q in questions.open] == [(7, 3, 6.0), (7, 5, 1.0)]


def two_in_one_place() -> AtlasState:
    """Return the row with node 1 a second time, as node 3, with an edge east to a node of its own."""
    state = row()
    graph = state.graph
    graph.add_node(NodeKind.MEET_POINT, 1.0, [math.pi, 0.0, 1.5])
    graph.add_node(NodeKind.BOUNDARY_POINT, 1.0, [math.pi])
    ends = graph.edges[1].ends
    edge = graph.connect((ends[0]._replace(node=3), ends[1]._replace(node=4)), 12.0, 1e-4, 12.0, 40)
    state.maps.put(edge.id, edge_map(40, 1))
    return state


def test_an_edge_that_matches_speaks_for_it_once() -> None:
    state = two_in_one_place()
    weighed = _weighed(state, Question(3, 1, EXACT, 1.0))
    assert weighed.compared == {(2, 1)}
    assert weighed.place_evidence == 1.0
    about_the_node, match = weighed.map_evidence
    assert about_the_node == 0.0
    assert match > 10.0
    again = _weighed(state, weighed)
    assert (again.map_evidence, again.place_evidence) == ((0.0, match), 1.0)


def test_an_edge_that_contradicts_costs_four_nats(monkeypatch: pytest.MonkeyPatch) -> None:
    state = two_in_one_place()
    state.maps.put(2, edge_map(40, 77))
    weighed = _weighed(state, Question(3, 1, EXACT, 1.0))
    assert (weighed.place_evidence, weighed.map_evidence) == (-3.0, (0.0,))
    monkeypatch.setattr(module, "twin_match", lambda *_: None)
    for shares, cost in ((True, 0.0), (False, 4.0)):  # of different lengths: it may have passed a node
        monkeypatch.setattr(module, "share_beginning", lambda *_, found=shares: found)
        assert _weighed(state, Question(3, 1, EXACT, 1.0)).place_evidence == 1.0 - cost


def test_a_merge_that_is_refused_costs_the_question_its_life(monkeypatch: pytest.MonkeyPatch) -> None:
    state = row()
    questions = asked((2, 1, 16.0))
    monkeypatch.setattr(module, "merge", lambda *_, **__: False)
    questions.review(state, set())
    assert not questions.open  # 20 nats lower, below what is kept


def test_what_has_become_unlikely_is_dropped_and_the_rest_kept() -> None:
    questions = asked((5, 1, -2.9), (5, 2, -3.1))
    questions.review(row(), set())
    assert [q.other for q in questions.open] == [1]


def test_only_a_node_that_was_touched_is_weighed_anew() -> None:
    state = two_in_one_place()
    questions = Questions(state.look_alikes)
    questions.add(Question(3, 1, EXACT, -2.0))
    questions.review(state, {0, 2})
    assert questions.open[0].compared == frozenset()
    questions.review(state, {1})
    assert questions.open[0].compared == {(2, 1)}
