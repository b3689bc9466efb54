"""Figures and report.json: written whole, the same for the same run, saying what they show."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from hslam_report.explored import ExploredGraph, ExploredNode, PlacedEdgeMap, Visit
from hslam_report.landmark_score import LandmarkScore
from hslam_report.map_figures import CHI_SQUARE_95, edge_map_figure, exaggeration, tied_maps_figure
from hslam_report.node_score import NodeMatches
from hslam_report.page import save
from hslam_report.path_figures import DrivenPath, laid_on_map, length_m, loop_figure, path_figure
from hslam_report.run_figures import Loop, enclosed_area_m2, widest_loop, write_figures
from hslam_report.run_report import RunFacts, report, write_report
from hslam_report.score import GraphScore
from hslam_sim.worlds import load_world
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

WORLD = load_world("small_world")


def driven() -> DrivenPath:
    """Return a square drive in the small world with odometry that starts elsewhere and drifts."""
    corners = np.array([(0.0, 0.0), (13.0, 0.0), (13.0, 9.0), (0.0, 9.0), (0.0, 0.0)])
    steps = np.linspace(0.0, 4.0, 201)
    xy = np.column_stack([np.interp(steps, range(5), corners[:, axis]) for axis in (0, 1)])
    theta = np.floor(np.minimum(steps, 3.999)) * math.pi / 2.0
    truth = np.column_stack([xy, theta])
    drift = np.linspace(0.0, 1.0, len(truth))[:, None] * np.array([0.8, -0.4, 0.0])
    return DrivenPath(np.column_stack([xy, theta]) + np.array([5.0, 5.0, 0.0]) + drift, truth)


def edge_map(std: float = 0.02) -> PlacedEdgeMap:
    """Return an edge-map along the small world's southern corridor."""
    landmarks = np.array([(1.0, 1.2), (3.5, -1.2), (6.0, 1.2)])
    covariance = np.diag([0.02**2, 0.0] + [std**2] * 6)
    return PlacedEdgeMap("3", 9.0, landmarks, covariance, SE2(), landmarks + 0.3, landmarks)


def figures() -> dict[str, Figure]:
    """Return one of each figure, drawn anew."""
    nodes = [(9.0, 0.0), (0.0, 4.0)]
    return {
        "3": path_figure(WORLD, driven(), nodes),
        "4": tied_maps_figure(WORLD, [edge_map()], nodes, 0),
        "5": edge_map_figure(edge_map()),
        "6": loop_figure(WORLD, driven(), 0, 200, (0.0, 0.0), "0"),
    }


def test_figures_are_written_twice_the_same_as_png_and_svg(tmp_path: Path) -> None:
    first, second = figures(), figures()
    for name, figure in first.items():
        paths = save(figure, tmp_path / "a", name)
        again = save(second[name], tmp_path / "b", name)
        assert [path.suffix for path in paths] == [".png", ".svg"]
        assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in again]
        assert min(path.stat().st_size for path in paths) > 5000


def test_titles_tell_lengths_gaps_and_the_exaggeration() -> None:
    drawn = {name: figure.axes[0].get_title() for name, figure in figures().items()}
    assert f"{length_m(driven().in_odom):.1f} m" in drawn["3"]
    assert "odometry 0.9 m off" in drawn["6"]
    assert f"ellipses x {exaggeration(edge_map())}" in drawn["5"]


def test_a_stop_at_the_end_changes_no_bit_of_a_length() -> None:
    poses = np.random.default_rng(3).normal(size=(1000, 3))
    lengths = {length_m(np.vstack([poses, np.repeat(poses[-1:], count, axis=0)])) for count in range(40)}
    assert len(lengths) == 1
    assert lengths.pop() == pytest.approx(sum(map(math.dist, poses[1:, :2], poses[:-1, :2])))


def test_the_path_by_odometry_is_true_where_it_is_laid_on() -> None:
    path = driven()
    for step in (0, 120):
        laid = laid_on_map(path, step)
        assert laid[step] == pytest.approx(path.in_map[step, :2])
    assert np.hypot(*(laid_on_map(path, 0)[-1] - path.in_map[-1, :2])) == pytest.approx(math.hypot(0.8, 0.4), rel=0.01)


@pytest.mark.parametrize("std", [0.001, 0.01, 0.05, 3.0])
def test_exaggerated_ellipses_keep_within_their_share(std: float) -> None:
    factor = exaggeration(edge_map(std))
    widest = math.sqrt(CHI_SQUARE_95) * max(std, 0.02)
    assert factor == 1 or factor * widest <= 0.05 * 9.0
    assert factor >= 1


def test_an_edge_map_without_landmarks_is_drawn() -> None:
    empty = PlacedEdgeMap("9", 4.0, np.empty((0, 2)), np.diag([0.01, 0.0]), SE2(), np.empty((0, 2)), np.empty((0, 2)))
    assert "0 landmarks" in edge_map_figure(empty).axes[0].get_title()


def test_the_loop_shown_is_the_widest_and_no_way_out_and_back(tmp_path: Path) -> None:
    path = driven()
    there_and_back = DrivenPath(
        np.vstack([path.in_odom[:50], path.in_odom[:50][::-1]]), np.vstack([path.in_map[:50], path.in_map[:50][::-1]])
    )
    corner = ExploredNode(7, NodeKind.MEET_POINT, 3, 1.2, (Visit(0, 0.0, 0.0), Visit(5, 0.1, 0.0)))
    graph = ExploredGraph((corner,), ())
    assert widest_loop(graph, path, {0: 0, 5: 200}) == Loop(7, 0, 200)
    assert enclosed_area_m2(path.in_map) == pytest.approx(13.0 * 9.0, rel=0.01)
    assert widest_loop(graph, there_and_back, {0: 0, 5: 99}) is None
    names = [path.name for path in write_figures(tmp_path, WORLD, path, graph, [edge_map()], {0: 0, 5: 200})]
    assert len(names) == 10
    assert [path.name for path in write_figures(tmp_path, WORLD, there_and_back, graph, [], {0: 0, 5: 99})] == names[:2]


def test_the_report_has_the_promised_fields_and_no_nan(tmp_path: Path) -> None:
    graph = GraphScore(2, 1, 13, 16, 13, 1.0, 0.5, 0.5, 0.25, False, 0, 0, 0, NodeMatches({}, {}, ()))
    landmarks = LandmarkScore(math.nan, 0.9, 0.5, 1.1, 4, 1)
    facts = RunFacts(True, 0, 3, 1, "wean_hall_6", 580.0, 1500.0, 60.0, 0, {"sim": 80.0, "atlas": 90.0})
    write_report(tmp_path / "report.json", report(facts, graph, landmarks))
    fields = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    promised = """completed seed world nodes edges true_nodes true_edges node_precision node_recall edge_precision
        edge_recall isomorphic path_length_m sim_time_s wall_time_s real_time_factor loop_closures_true
        loop_closures_false landmark_rmse_edge_m landmark_rmse_chained_m landmark_rmse_global_m
        nees_mean collisions peak_rss_mb"""
    assert set(promised.split()) <= set(fields)
    assert fields["completed"]
    assert fields["landmark_rmse_edge_m"] is None
    assert fields["real_time_factor"] == 25.0
    assert list(fields["peak_rss_mb"]) == ["atlas", "sim"]


@pytest.mark.parametrize(("finished", "unexplored"), [(False, 0), (True, 2)])
def test_a_run_with_something_left_is_not_complete(finished: bool, unexplored: int) -> None:
    facts = RunFacts(finished, unexplored, 5, 1, "small_world", 10.0, 30.0, 2.0, 0, {})
    assert not facts.completed
