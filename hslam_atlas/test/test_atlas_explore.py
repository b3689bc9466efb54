"""The next branch to drive."""

import math
from dataclasses import replace

import pytest
from scripted_level import row

from hslam_atlas.config import AtlasConfig
from hslam_atlas.explore import next_branch, unexplored
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.questions import Question, Questions
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_atlas.whereabouts import Here
from hslam_types.errors import ConfigurationError
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2


@pytest.mark.parametrize(("come", "expected"), [(0, 3), (1, 0), (2, 1), (None, 0)])
def test_the_sharpest_turn_goes_first(come: int | None, expected: int) -> None:
    """Four ways at 0, 80, 170 and -60 degrees, none explored but the one come along."""
    store = AtlasStore()
    graph, _ = store.load()
    node = graph.add_node(NodeKind.MEET_POINT, 1.3, [math.radians(b) for b in (0.0, 80.0, 170.0, -60.0)])
    if come is not None:
        node.branches[come].given_up = True
    alike = LookAlikes(1e-4)
    state = AtlasState(AtlasConfig(), graph, store, alike)
    here = Here(node.id, (0, 1, 2, 3), come, -1, None)
    assert next_branch(state, Questions(alike), here) == expected


def test_slots_leave_out_what_was_given_up_unless_it_carries_an_edge() -> None:
    store = AtlasStore()
    graph, _ = store.load()
    node = graph.add_node(NodeKind.MEET_POINT, 1.3, [2.0, -1.0, 0.5, -3.0])
    node.branches[1].given_up = node.branches[2].given_up = True
    node.branches[2].edge = 7
    assert node.slots() == [3, 2, 0]


def test_a_mission_that_does_not_exist_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="one of explore, localise, none, not 'fly'"):
        AtlasConfig(mission="fly")


def asked(evidence: float, *, seen: tuple[int, ...] = (0, 1, 2)) -> int | None:
    """Return the branch driven next at node 3, that may be node 1 of a row of corridors, of 12 m west and 9 m east."""
    state = row()
    graph = state.graph
    graph.put_edge(replace(graph.edges[1], path_length_m=9.0))
    node = graph.add_node(NodeKind.MEET_POINT, 1.0, [math.pi, 0.0, 1.5])
    questions = Questions(state.look_alikes)
    questions.add(Question(node.id, 1, UncertainPose.exact(SE2()), evidence))
    return next_branch(state, questions, Here(node.id, seen, 2, -1, None))


def test_a_likely_answer_is_confirmed_by_the_shortest_edge_that_would_be_known() -> None:
    assert asked(1.0) == 1
    assert asked(1.0, seen=(0, 2)) == 0
    assert asked(-2.9) == 1
    assert asked(-3.1) == 2  # not worth a drive: the branch come along is the sharpest turn


def test_with_nothing_left_here_the_nearest_node_with_a_branch_unexplored_is_made_for() -> None:
    """Node 1 has one to the north; from the row's west end the way leads east, from its east end west."""
    state = row()
    for here in (0, 2):
        assert next_branch(state, Questions(state.look_alikes), Here(here, (0,), 0, -1, None)) == 0
    state.graph.nodes[1].branches[2].given_up = True
    assert next_branch(state, Questions(state.look_alikes), Here(0, (0,), 0, -1, None)) is None
    assert unexplored(state.graph) == 0


def test_a_branch_out_of_sight_is_come_back_for_when_nothing_else_is_left() -> None:
    """Of the row's east end one branch is unexplored and not seen on this visit: to the neighbour and back, thrice."""
    state = row()
    state.graph.nodes[1].branches[2].given_up = True
    hidden = state.graph.nodes[2].add_branch(math.radians(90.0))
    here = Here(2, (0,), 0, -1, None)
    for unseen, expected in ((1, 0), (2, 0), (3, None)):
        hidden.unseen = unseen
        assert next_branch(state, Questions(state.look_alikes), here) == expected
