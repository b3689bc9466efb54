"""A drive of another length on the branch of a known edge: which of the two stays."""

from dataclasses import replace

import numpy as np
import pytest
from test_atlas_alignment import EAST, WEST, drives

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import Edge, EdgeEnd
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.retrace import compare
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.tie import Drive, Outcome, connect, tie
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

FORWARD = UncertainPose.exact(SE2())


def shortened(edge_map: EdgeMap, length_m: float) -> EdgeMap:
    """Return the map a drive would have made that had stopped on the way."""
    kept = np.flatnonzero(edge_map.landmarks[:, 0] < length_m + 3.0)
    rows = np.concatenate(([0, 1], (2 + 2 * kept[:, None] + np.arange(2)).reshape(-1)))
    return replace(
        edge_map,
        traversal=edge_map.traversal + 1000,
        terminal_x=length_m,
        landmarks=edge_map.landmarks[kept],
        covariance=edge_map.covariance[np.ix_(rows, rows)],
        sightings=tuple(edge_map.sightings[i] for i in kept),
        path_length_m=length_m,
    )


def atlas_with(edge_map: EdgeMap, driven: int) -> tuple[AtlasState, Edge]:
    """Return three nodes of one branch each, an edge between the first two that was driven so many times."""
    config = AtlasConfig()
    store = AtlasStore()
    graph, _ = store.load()
    for _ in range(3):
        graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0])
    state = AtlasState(config, graph, store, LookAlikes(config.repetition))
    edge = connect(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(1, 0, FORWARD), edge_map))
    edge = replace(edge, traversals=tuple(range(driven)))
    graph.put_edge(edge)
    return state, edge


WAY, SAME_WAY = drives(2, 60, bearing=WEST)
(OTHER_WAY,) = drives(1, 62, bearing=EAST)
SHORT = 12.0


@pytest.mark.parametrize(
    ("known", "driven", "drive", "outcome"),
    [
        pytest.param(WAY, 3, shortened(SAME_WAY, SHORT), Outcome.CONNECTED, id="the edge had passed a node"),
        pytest.param(shortened(WAY, SHORT), 1, SAME_WAY, Outcome.PASSED, id="the drive passed a node"),
        pytest.param(shortened(OTHER_WAY, SHORT), 1, WAY, Outcome.CONNECTED, id="the edge was never confirmed"),
        pytest.param(shortened(OTHER_WAY, SHORT), 2, WAY, Outcome.PASSED, id="longer, but elsewhere"),
        pytest.param(WAY, 2, shortened(OTHER_WAY, SHORT), Outcome.PASSED, id="shorter, but elsewhere"),
    ],
)
def test_what_both_passed_decides_then_how_often(known: EdgeMap, driven: int, drive: EdgeMap, outcome: Outcome) -> None:
    state, edge = atlas_with(known, driven)
    assert tie(state, Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), drive)) is outcome
    assert (edge.id in state.graph.edges) == (outcome is Outcome.PASSED)
    assert len(state.graph.edges) == 1
    assert len(state.graph.links) == 1


def test_a_dead_end_cannot_have_been_passed_unnoticed() -> None:
    state, edge = atlas_with(WAY, 1)
    state.graph.nodes[2].kind = NodeKind.BOUNDARY_POINT
    drive = Drive(EdgeEnd(0, 0, FORWARD), EdgeEnd(2, 0, FORWARD), shortened(SAME_WAY, SHORT))
    assert tie(state, drive) is Outcome.PASSED
    assert edge.id in state.graph.edges


def test_a_drive_with_one_bad_homing_is_still_along_its_edge() -> None:
    """The far meet point is taken for 0.4 m farther on: more than six times what it mostly scatters."""
    state, edge = atlas_with(WAY, 1)
    stray = replace(SAME_WAY, terminal_x=SAME_WAY.terminal_x + 0.4)
    match = compare(state, edge, 0, stray, FORWARD)
    assert match is not None
    assert match.agrees
    assert compare(state, edge, 0, replace(OTHER_WAY, terminal_x=WAY.terminal_x), FORWARD) is None
