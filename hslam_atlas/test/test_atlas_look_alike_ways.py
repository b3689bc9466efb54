"""Drives are compared with ways that they cannot be: how often those look alike is learnt."""

import math
from dataclasses import replace

import pytest
from test_atlas_alignment import EAST, WEST, drives

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.look_alike_ways import learn_look_alike_ways
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.tie import Drive, connect
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

FIRST, ALIKE = drives(2, 60, bearing=WEST)
UNLIKE, _ = drives(2, 70, bearing=EAST)
OTHER = replace(FIRST, landmarks=UNLIKE.landmarks, covariance=UNLIKE.covariance, sightings=UNLIKE.sightings)
"""The same way by length and directions, with other things along it."""
EXACT = UncertainPose.exact(SE2())


def way_and_start(away_m: float, known: EdgeMap = FIRST) -> tuple[AtlasState, EdgeEnd]:
    """Return an atlas of one way, and a node as far from its ends to which a link alone leads."""
    config, store = AtlasConfig(), AtlasStore()
    graph, _ = store.load()
    state = AtlasState(config, graph, store, LookAlikes(config.repetition))
    for _ in range(3):
        graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0, math.pi])
    connect(state, Drive(EdgeEnd(0, 0, EXACT), EdgeEnd(1, 0, EXACT), replace(known, traversal=1)))
    graph.add_link(0, 2, UncertainPose.diagonal(SE2(0.0, away_m, 0.0), 0.1, 0.01), away_m)
    return state, EdgeEnd(2, 0, EXACT)


@pytest.mark.parametrize(("drive", "alike"), [(ALIKE, 1), (OTHER, 0)])
def test_a_way_elsewhere_of_the_same_length_is_compared(drive: EdgeMap, alike: int) -> None:
    state, start = way_and_start(60.0)
    learn_look_alike_ways(state, start, drive)
    assert state.look_alikes.ways_alike == alike
    assert 1 <= state.look_alikes.ways_compared <= 2
    assert state.look_alikes.compared == 0


def test_a_way_that_may_begin_here_and_one_of_another_length_tell_nothing() -> None:
    state, start = way_and_start(0.3)
    known = state.graph.edges[0]
    # Its far end is elsewhere: seen from there it is another way.
    learn_look_alike_ways(state, start, ALIKE)
    assert state.look_alikes.ways_alike == 0
    assert state.look_alikes.ways_compared <= 1
    state, start = way_and_start(60.0, replace(FIRST, path_length_m=known.path_length_m + 9.0))
    learn_look_alike_ways(state, start, ALIKE)
    assert state.look_alikes.ways_compared == 0


def test_no_more_than_a_few_are_compared() -> None:
    state, start = way_and_start(60.0)
    for _ in range(8):
        first, second = (state.graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0]).id for _ in range(2))
        connect(state, Drive(EdgeEnd(first, 0, EXACT), EdgeEnd(second, 0, EXACT), replace(OTHER, traversal=first)))
        state.graph.add_link(2, first, UncertainPose.diagonal(SE2(0.0, 60.0, 0.0), 0.1, 0.01), 60.0)
    learn_look_alike_ways(state, start, ALIKE)
    assert state.look_alikes.ways_compared == 4
