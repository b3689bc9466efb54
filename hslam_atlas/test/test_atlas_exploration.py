"""Whole explorations at the level of events: the atlas must become the floor, and no loop may be closed wrongly."""

import math

import networkx as nx
import numpy as np
import pytest
from corridor_floor import Corridor, CorridorFloor, comb, furnish, grid, spoked_ring, theta, wean_hall
from edge_walker import EdgeWalker, WalkNoise
from explored import explore
from hash_seeds import under_two_hash_seeds

from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_types.gvg_events import GoalKind, NodeKind

ROUGH = WalkNoise(
    node_m=0.06, bearing=math.radians(6.0), drift_per_50m=math.radians(1.2), degree_misread=0.1,
    node_missed=0.05, landmark_missed=0.12, clutter=0.08,
)  # fmt: skip


def floor_of(corridors: tuple[Corridor, ...], seed: int, *, period_m: float = 0.0) -> CorridorFloor:
    return furnish(corridors, np.random.default_rng(1000 + seed), period_m=period_m)


@pytest.mark.parametrize("seed", range(4))
def test_the_papers_floor_is_explored_to_isomorphism(seed: int) -> None:
    end = explore(floor_of(wean_hall(), seed), 0, seed, WalkNoise())
    assert end.finished
    assert end.false_closures() == 0
    assert end.is_isomorphic()


@pytest.mark.parametrize("seed", range(2))
def test_a_grid_of_short_edges(seed: int) -> None:
    end = explore(floor_of(grid(4, 3, 15.0), seed), 0, seed, WalkNoise())
    assert end.finished
    assert end.is_isomorphic()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "corridors",
    [
        theta(12.0, 10.0, 10.0),
        theta(20.0, 10.0, 10.3),
        theta(8.0, 8.0, 8.0),
        theta(12.0, 10.0, 11.0),
        spoked_ring(6, 12.0),
    ],
    ids=["theta", "nearly even", "square", "uneven", "ring"],
)
def test_ways_of_one_length_between_the_same_nodes_are_told_apart(corridors: tuple[Corridor, ...], seed: int) -> None:
    end = explore(floor_of(corridors, seed), 0, seed, ROUGH)
    assert end.finished
    assert end.false_closures() == 0
    assert end.is_isomorphic()


def test_rough_sensing_closes_no_loop_wrongly() -> None:
    """Degrees misread in one visit of ten, a node passed in twenty, twice the drift, more clutter."""
    ends = [explore(floor_of(wean_hall(), seed), 0, seed, ROUGH, goals=45) for seed in (4, 7)]
    assert [end.false_closures() for end in ends] == [0, 0]
    assert all(end.finished for end in ends)
    assert all(end.is_isomorphic() for end in ends)


def test_places_that_look_alike_are_not_taken_for_one() -> None:
    """A comb with one landmark pattern everywhere and drift beyond its pitch: nothing tells a tooth from the next."""
    floor = floor_of(comb(8, 10.0, 8.0), 1, period_m=5.0)
    noise = WalkNoise(drift_per_50m=math.radians(3.0), slip_per_metre=0.02)
    end = explore(floor, 4, 1, noise, goals=30)
    assert end.false_closures() == 0
    assert end.server.state.look_alikes.alike > 10
    assert end.server.questions.open


def test_landmarks_that_repeat_do_not_matter_where_poses_tell() -> None:
    end = explore(floor_of(grid(4, 3, 15.0), 2, period_m=5.0), 0, 2, WalkNoise())
    assert end.false_closures() == 0
    assert end.is_isomorphic()


def atlas_of_a_seed() -> str:
    """Return the content of an atlas after some goals."""
    store = AtlasStore()
    explore(floor_of(wean_hall(), 3), 0, 3, WalkNoise(), goals=12, store=store)
    return "\n".join(store.dump())


def test_same_inputs_give_the_same_atlas() -> None:
    first, second = under_two_hash_seeds(atlas_of_a_seed)
    assert first == second


def test_mission_none_maps_what_is_driven_and_asks_for_nothing() -> None:
    """Events carry the map, commands do not: the same atlas from a replay."""
    floor = floor_of(wean_hall(), 4)
    walker = EdgeWalker(floor, 0, np.random.default_rng(4), WalkNoise())
    driver, listener = AtlasServer(), AtlasServer()
    listener.stop()
    goal = driver.step((), (), ()).goal
    assert listener.step((), (), ()).goal is None
    for _ in range(10):
        assert goal is not None
        for step in walker.follow(goal):
            goal = driver.step(step.events, step.edge_maps, step.links).goal
            assert listener.step(step.events, step.edge_maps, step.links).goal is None
    assert list(driver.store.dump()) == list(listener.store.dump())
    assert nx.is_connected(nx.Graph([(e.ends[0].node, e.ends[1].node) for e in listener.state.graph.edges.values()]))


def test_an_end_with_branches_out_of_reach_is_not_taken_for_completeness() -> None:
    """A second part of the graph that no edge leads to: the run ends, and says what is left."""
    server = AtlasServer()
    walker = EdgeWalker(floor_of(grid(2, 2, 15.0), 0), 0, np.random.default_rng(0), WalkNoise(degree_misread=0.0))
    server.state.graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0, 2.0, -2.0])
    output = server.step((), (), ())
    for _ in range(20):
        assert output.goal is not None
        if output.finished:
            break
        for step in walker.follow(output.goal):
            output = server.step(step.events, step.edge_maps, step.links)
    assert output.finished
    assert server.unexplored == 3
    assert sum(b.unexplored for node in server.state.graph.nodes.values() for b in node.branches.values()) == 3


def test_first_goal_is_to_reach_the_gvg() -> None:
    output = AtlasServer().step((), (), ())
    assert output.goal is not None
    assert output.goal.kind is GoalKind.ACCESS
    assert not output.finished
