"""The true reduced GVG: counts on known floors, shapes with a known answer, and standing still under change."""

import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hslam_sim.truth import Rules, TrueGvg, draw_true_gvg, true_gvg
from hslam_sim.truth.true_gvg import single_gvg
from hslam_sim.world import World
from hslam_sim.worlds import load_world
from hslam_types.se2 import SE2

MAPS = Path(__file__).resolve().parents[2].parent / "shared" / "maps"


def crossing(width: float, depth: float, offset: float = 0.0) -> World:
    """Return four 12 m corridors about the origin; the southern one is ``depth`` deep and ``offset`` to the east."""
    half = width / 2.0
    space = shapely.union_all(
        [
            shapely.box(-12.0, -half, 12.0, half),
            shapely.box(-half, 0.0, half, 12.0),
            shapely.box(offset - half, -half - depth, offset + half, 0.0),
        ]
    )
    assert isinstance(space, shapely.Polygon)
    return World("crossing", space, SE2(-6.0, 0.0, 0.0), np.empty((0, 2)))


def counts(gvg: TrueGvg) -> tuple[int, int, int, int]:
    """Return boundary nodes, meet points, edges and cycles."""
    boundary = sum(node.is_boundary for node in gvg.nodes)
    return boundary, len(gvg.nodes) - boundary, len(gvg.edges), gvg.cycles


def assert_planar(gvg: TrueGvg) -> None:
    """Check Euler's formula on the faces the cyclic orders give, and that every edge ends at its nodes."""
    assert len(gvg.nodes) - len(gvg.edges) + len(gvg.faces) == 2
    ends = Counter(end for node in gvg.nodes for end in node.branches)
    assert ends == Counter((edge, end) for edge in range(len(gvg.edges)) for end in (0, 1))


@pytest.fixture(scope="module")
def papers_floor() -> tuple[World, TrueGvg]:
    world = load_world("wean_hall_6")
    return world, true_gvg(world)


def test_the_papers_floor_has_the_papers_graph(papers_floor: tuple[World, TrueGvg]) -> None:
    _, gvg = papers_floor
    assert counts(gvg) == (4, 9, 16, 4)
    assert Counter(node.degree for node in gvg.nodes) == {4: 1, 3: 8, 1: 4}
    assert gvg.all_core
    assert not gvg.only_in_variants
    assert_planar(gvg)


def test_the_outer_loop_is_longer_than_three_hundred_metres(papers_floor: tuple[World, TrueGvg]) -> None:
    _, gvg = papers_floor
    outside = max(gvg.faces, key=lambda face: sum(gvg.edges[edge].length_m for edge, _ in face))
    dead_ends = {edge for edge, end in outside if (edge, 1 - end) in outside}
    assert sum(gvg.edges[edge].length_m for edge, _ in outside if edge not in dead_ends) > 300.0


def test_edges_run_where_a_robot_fits(papers_floor: tuple[World, TrueGvg]) -> None:
    world, gvg = papers_floor
    for edge in gvg.edges:
        clearance = shapely.distance(world.free_space.boundary, shapely.points(edge.polyline))
        assert clearance.min() >= 0.25
        u, v = gvg.nodes[edge.u], gvg.nodes[edge.v]
        assert tuple(edge.polyline[0]) == (u.x, u.y)
        assert tuple(edge.polyline[-1]) == (v.x, v.y)


def test_the_branches_of_the_crossing_go_round_counter_clockwise(papers_floor: tuple[World, TrueGvg]) -> None:
    _, gvg = papers_floor
    node = next(node for node in gvg.nodes if node.degree == 4)
    away = []
    for edge, end in node.branches:
        line = gvg.edges[edge].polyline if end == 0 else gvg.edges[edge].polyline[::-1]
        beyond = line[np.hypot(line[:, 0] - node.x, line[:, 1] - node.y) > 3.0][0]
        away.append(math.atan2(beyond[1] - node.y, beyond[0] - node.x))
    turns = [(b - a) % (2.0 * math.pi) for a, b in zip(away, [*away[1:], away[0]], strict=True)]
    assert turns == pytest.approx([math.pi / 2.0] * 4, abs=0.1)


@pytest.mark.parametrize("seed", [0, 1, 2, 9])
def test_the_papers_graph_stands_still_under_noise_and_other_rules(seed: int) -> None:
    # Seed 9 also leaves fragments of ridges about pilasters, connected to nothing.
    spur, merge, span, loop = np.random.default_rng(seed).uniform(0.7, 1.3, 4).tolist()
    rules = Rules(spur_ratio=1.5 * spur, merge_ratio=merge, span_ratio=2.0 * span, loop_ratio=3.2 * loop)
    assert counts(single_gvg(load_world("wean_hall_6"), rules, seed)) == (4, 9, 16, 4)


def test_the_small_world_has_one_loop_and_two_dead_ends() -> None:
    gvg = true_gvg(load_world("small_world"))
    assert counts(gvg) == (2, 2, 4, 1)
    assert gvg.all_core
    assert_planar(gvg)


@pytest.mark.parametrize(
    ("offset", "degrees"),
    [(0.0, {4: 1, 1: 4}), (1.0, {4: 1, 1: 4}), (1.6, {3: 2, 1: 4}), (4.0, {3: 2, 1: 4})],
)
def test_crossings_a_little_apart_are_one_node(offset: float, degrees: dict[int, int]) -> None:
    gvg = single_gvg(crossing(2.4, 8.0, offset), Rules())
    assert Counter(node.degree for node in gvg.nodes) == degrees
    assert_planar(gvg)


@pytest.mark.parametrize(("depth", "boundaries"), [(1.5, 3), (6.0, 4)])
def test_a_dead_end_counts_from_some_depth_on(depth: float, boundaries: int) -> None:
    assert counts(single_gvg(crossing(2.4, depth), Rules()))[0] == boundaries


def test_a_wide_hall_has_a_ring_of_edges_along_its_walls() -> None:
    hall = shapely.box(-15.0, -15.0, 15.0, 15.0)
    corridors = shapely.union_all([shapely.box(-30.0, -1.2, 30.0, 1.2), shapely.box(-1.2, -30.0, 1.2, 30.0)])
    space = hall.union(corridors)
    assert isinstance(space, shapely.Polygon)
    gvg = single_gvg(World("hall", space, SE2(-20.0, 0.0, 0.0), np.empty((0, 2))), Rules())
    assert counts(gvg) == (4, 4, 8, 1)
    # The open middle begins 5 m from the walls, and the edges lie half-way.
    halfway = [edge for edge in gvg.edges if gvg.nodes[edge.u].degree == gvg.nodes[edge.v].degree == 3]
    away = [shapely.Point(xy).distance(hall.exterior) for edge in halfway for xy in edge.polyline[20:-20]]
    assert 2.4 < np.median(away) < 2.6


def test_a_pillar_out_in_the_open_is_out_of_reach_of_the_graph() -> None:
    hall = shapely.box(0.0, 0.0, 40.0, 40.0).difference(shapely.box(19.0, 19.0, 21.0, 21.0))
    assert isinstance(hall, shapely.Polygon)
    by_wall = single_gvg(World("hall", hall, SE2(2.0, 20.0, 0.0), np.empty((0, 2))), Rules(spur_least_m=2.0))
    by_pillar = single_gvg(World("hall", hall, SE2(17.0, 20.0, 0.0), np.empty((0, 2))), Rules(spur_least_m=2.0))
    assert by_wall.nodes == by_pillar.nodes == ()  # a ring each, on which nothing is decided


def test_a_corridor_without_a_choice_has_two_boundary_nodes_and_a_ring_none() -> None:
    corridor = World("corridor", shapely.box(0.0, 0.0, 20.0, 2.0), SE2(3.0, 1.0, 0.0), np.empty((0, 2)))
    assert counts(single_gvg(corridor, Rules())) == (2, 0, 1, 0)
    ring_space = shapely.Point(0.0, 0.0).buffer(10.0).difference(shapely.Point(0.0, 0.0).buffer(8.0))
    assert isinstance(ring_space, shapely.Polygon)
    ring = World("ring", ring_space, SE2(9.0, 0.0, 0.0), np.empty((0, 2)))
    assert single_gvg(ring, Rules()).nodes == ()


@settings(max_examples=15, deadline=None)
@given(
    theta=st.floats(-math.pi, math.pi),
    x=st.floats(-100.0, 100.0),
    y=st.floats(-100.0, 100.0),
)
def test_moving_the_world_moves_the_graph(theta: float, x: float, y: float) -> None:
    world = crossing(2.4, 8.0, 3.0)
    motion = SE2(x, y, theta)
    moved = World("moved", shapely.transform(world.free_space, motion.apply_all), motion @ world.start, world.landmarks)
    before, after = single_gvg(world, Rules()), single_gvg(moved, Rules())
    assert counts(before) == counts(after)
    expected = motion.apply_all(np.array([(node.x, node.y) for node in before.nodes]))
    found = np.array([(node.x, node.y) for node in after.nodes])
    # Samples of the walls fall elsewhere only by rounding, so nodes stay within a fraction of their spacing.
    assert np.hypot(*(expected[:, None] - found[None]).transpose(2, 0, 1)).min(axis=1).max() < 0.02


def test_a_robot_too_wide_for_a_door_does_not_see_the_room() -> None:
    space = shapely.union_all(
        [shapely.box(0.0, 0.0, 20.0, 2.4), shapely.box(8.0, 2.6, 14.0, 7.0), shapely.box(10.0, 2.4, 10.8, 2.6)]
    )
    assert isinstance(space, shapely.Polygon)
    world = World("door", space, SE2(3.0, 1.2, 0.0), np.empty((0, 2)))
    assert counts(true_gvg(world, robot_radius=0.19)) == (3, 1, 3, 0)
    assert counts(true_gvg(world, robot_radius=0.45)) == (2, 0, 1, 0)


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_the_picture_is_written(tmp_path: Path, suffix: str) -> None:
    world = crossing(2.4, 8.0)
    path = tmp_path / f"gvg{suffix}"
    draw_true_gvg(world, single_gvg(world, Rules()), path)
    assert path.stat().st_size > 5000


@pytest.mark.parametrize(
    ("name", "expected"),
    [("cross", (11, 21, 39, 8)), ("grid1", (0, 22, 37, 16)), ("spiral1", (2, 0, 1, 0)), ("depot", (0, 16, 30, 15))],
)
def test_clean_maps_of_others_have_their_counts(name: str, expected: tuple[int, int, int, int]) -> None:
    path = MAPS / f"{name}.yaml"
    if not path.is_file():
        pytest.skip(f"{path} is not here")
    gvg = true_gvg(load_world(str(path)))
    assert counts(gvg) == expected
    assert gvg.all_core
    assert_planar(gvg)


@pytest.mark.parametrize(("name", "nodes", "edges"), [("aces", 77, 90), ("intel", 59, 77)])
def test_ragged_maps_come_near_the_counts_of_another_computation(name: str, nodes: int, edges: int) -> None:
    path = MAPS / f"{name}.yaml"
    if not path.is_file():
        pytest.skip(f"{path} is not here")
    world = load_world(str(path))
    gvg = single_gvg(world, Rules())
    assert len(gvg.nodes) == pytest.approx(nodes, rel=0.06)
    assert len(gvg.edges) == pytest.approx(edges, rel=0.06)
    assert_planar(gvg)
