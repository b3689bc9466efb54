"""The next branch to drive."""

import math

import pytest

from hslam_atlas.config import AtlasConfig
from hslam_atlas.explore import next_branch
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.questions import Questions
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.whereabouts import Here
from hslam_types.errors import ConfigurationError
from hslam_types.gvg_events import NodeKind


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
    with pytest.raises(ConfigurationError, match="one of explore, none, not 'fly'"):
        AtlasConfig(mission="fly")
