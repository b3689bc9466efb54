"""What is driven once more when nothing unexplored is in reach."""

import math

import numpy as np
import pytest
from corridor_floor import furnish, grid
from edge_walker import WalkNoise
from explored import explore
from scripted_level import LENGTH_M, row

from hslam_atlas.config import AtlasConfig
from hslam_atlas.explore import driven_once
from hslam_atlas.second_looks import SecondLooks
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_atlas.whereabouts import Here
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

WEST = Here(0, (0,), 0, -1, None)


def with_island(x: float, y: float) -> AtlasState:
    """Return a row explored to its end, and a node at (x, y) that a drive from node 0 has noticed, with no edge."""
    state = row()
    state.graph.nodes[1].branches[2].given_up = True
    island = state.graph.add_node(NodeKind.MEET_POINT, 1.0, [math.pi, 0.0, 1.5])
    state.graph.add_link(0, island.id, UncertainPose.exact(SE2(x, y, 0.0)), x)
    return state


@pytest.mark.parametrize(("x", "y", "edge"), [(0.4, 0.0, 0), (0.5, 0.2, 0), (1.6, 0.0, 1), (0.5, 1.5, None)])
def test_an_edge_that_may_have_passed_an_island_is_driven_twice_more(x: float, y: float, edge: int | None) -> None:
    """In corridors' lengths: on the first corridor, beside it, on the second, too far aside for any."""
    state = with_island(x * LENGTH_M, y * LENGTH_M)
    looks = SecondLooks(state)
    middle = Here(1, (0, 1), 0, -1, None)
    for here in (middle, WEST) if edge == 0 else (middle, middle):
        assert looks.next_branch(here) == (edge if here is middle else (0 if edge is not None else None))
    assert looks.next_branch(middle) is None


def test_the_way_to_such_an_edge_is_driven_first() -> None:
    looks = SecondLooks(with_island(1.5 * LENGTH_M, 0.0))
    assert [looks.next_branch(WEST) for _ in range(3)] == [0, 0, 0]
    assert looks.next_branch(Here(1, (0, 1), 0, -1, None)) == 1


def test_without_an_island_every_edge_driven_once_is_driven_again_only_if_asked() -> None:
    state = with_island(0.5 * LENGTH_M, 0.0)
    for branch in state.graph.nodes[3].branches.values():
        branch.given_up = True
    assert SecondLooks(state).next_branch(WEST) is None
    state.config = state.config.__class__(drive_twice=True)
    assert SecondLooks(state).next_branch(WEST) == 0


@pytest.mark.parametrize("twice", [False, True])
def test_a_junction_passed_unnoticed_is_found_where_every_edge_is_driven_twice(twice: bool) -> None:
    """A robot that passes one junction in eight; else it is missing, and the count of edges driven once says so."""
    floor = furnish(grid(4, 4, 12.0), np.random.default_rng(1002))
    end = explore(floor, 0, 2, WalkNoise(node_missed=0.12), goals=250, config=AtlasConfig(drive_twice=twice))
    assert end.finished
    assert end.is_isomorphic() is twice
    assert driven_once(end.server.state.graph) == 0 if twice else driven_once(end.server.state.graph) > 0
