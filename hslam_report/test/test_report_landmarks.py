"""Landmark errors: zero on the truth, as large as what was added, consistent where the covariance is right."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_report.explored import PlacedEdgeMap, edge_frame_in_map, true_meet_point
from hslam_report.landmark_score import rigid_fit, score_landmarks
from hslam_types.gvg_events import NodeKind, NodeView
from hslam_types.se2 import SE2, Array

WORLD = np.array([(x + 0.3 * math.sin(7.0 * x), y) for x in range(0, 30, 2) for y in (-1.2, 1.2, 8.0)])
ELSEWHERE = SE2(12.0, -40.0, 2.0)


def placed(
    frame: SE2, std: float = 0.0, rng: np.random.Generator | None = None, promised: float = 0.05
) -> PlacedEdgeMap:
    """Return an edge-map of all landmarks, its errors of ``std`` and its covariance of ``promised`` (m)."""
    in_edge = frame.inverse().apply_all(WORLD)
    if rng is not None:
        in_edge = in_edge + rng.normal(0.0, std, in_edge.shape)
    covariance = np.diag([0.01, 0.0] + [promised**2] * (2 * len(WORLD)))
    chained, optimised = SE2(1.0, 2.0, -1.0) @ frame, ELSEWHERE @ frame
    return PlacedEdgeMap(
        "0", 28.0, in_edge, covariance, frame, chained.apply_all(in_edge), optimised.apply_all(in_edge)
    )


def test_a_perfect_map_has_no_error_wherever_the_picture_lies() -> None:
    score = score_landmarks([placed(SE2(0.0, 0.0, 0.3)), placed(SE2(28.0, 1.0, -2.9))], WORLD)
    assert score.rmse_edge_m == pytest.approx(0.0, abs=1e-9)
    assert score.rmse_chained_m == pytest.approx(0.0, abs=1e-9)
    assert score.rmse_global_m == pytest.approx(0.0, abs=1e-9)
    assert (score.mapped, score.false) == (2 * len(WORLD), 0)


def test_errors_and_consistency_are_what_was_put_in() -> None:
    rng = np.random.default_rng(5)
    maps = [placed(SE2(0.0, 0.0, 0.3 * k), 0.05, rng) for k in range(30)]
    score = score_landmarks(maps, WORLD)
    assert score.rmse_edge_m == pytest.approx(0.05 * math.sqrt(2.0), rel=0.06)
    assert score.nees_mean == pytest.approx(1.0, rel=0.1)
    sure = score_landmarks([placed(SE2(), 0.05, np.random.default_rng(6), promised=0.025)], WORLD)
    assert sure.nees_mean == pytest.approx(4.0, rel=0.35)


def test_a_map_misplaced_by_the_atlas_shows_in_the_error_of_that_picture_only() -> None:
    right, wrong = placed(SE2()), placed(SE2(5.0, 0.0, 0.0))
    chained = replace(wrong, chained=wrong.chained + np.array([0.0, 1.0]))
    score = score_landmarks([right, chained], WORLD)
    assert score.rmse_edge_m == pytest.approx(0.0, abs=1e-9)
    # The best single motion splits the metre between the two maps.
    assert score.rmse_chained_m == pytest.approx(0.5, rel=0.02)
    assert score.rmse_global_m == pytest.approx(0.0, abs=1e-9)
    optimised = replace(wrong, optimised=wrong.optimised + np.array([0.0, 1.0]))
    assert score_landmarks([right, optimised], WORLD).rmse_global_m == pytest.approx(0.5, rel=0.02)


def test_a_closed_edge_counts_in_the_pictures_but_not_in_its_own_frame() -> None:
    """Its frame is turned by what the picture says, not by the truth."""
    turned = replace(placed(SE2()), frame_in_map=SE2(0.0, 0.0, math.radians(1.0)))
    score = score_landmarks([placed(SE2()), replace(turned, closed=True)], WORLD)
    assert score.rmse_edge_m == pytest.approx(0.0, abs=1e-9)
    assert score.rmse_chained_m == pytest.approx(0.0, abs=1e-9)
    assert (score.mapped, score.false) == (2 * len(WORLD), 0)
    assert score_landmarks([placed(SE2()), turned], WORLD).rmse_edge_m > 0.1
    alone = score_landmarks([replace(turned, closed=True)], WORLD)
    assert math.isnan(alone.rmse_edge_m)
    assert alone.rmse_global_m == pytest.approx(0.0, abs=1e-9)


def test_a_landmark_that_is_not_there_is_false() -> None:
    true = placed(SE2())
    landmarks = np.vstack([true.landmarks, (15.0, 4.0)])
    covariance = np.diag([0.01, 0.0] + [0.0025] * (2 * len(landmarks)))
    score = score_landmarks([PlacedEdgeMap("0", 28.0, landmarks, covariance, SE2(), landmarks, landmarks)], WORLD)
    assert (score.mapped, score.false) == (len(WORLD) + 1, 1)
    assert score.rmse_edge_m == pytest.approx(0.0, abs=1e-9)


def test_without_landmarks_there_is_no_figure() -> None:
    empty = PlacedEdgeMap("0", 5.0, np.empty((0, 2)), np.zeros((2, 2)), SE2(), np.empty((0, 2)), np.empty((0, 2)))
    score = score_landmarks([empty], WORLD)
    assert math.isnan(score.rmse_edge_m)
    assert math.isnan(score.nees_mean)
    assert score.mapped == 0


@given(
    x=st.floats(-50, 50),
    y=st.floats(-50, 50),
    theta=st.floats(-3.1, 3.1),
    points=st.lists(st.tuples(st.floats(-20, 20), st.floats(-20, 20)), min_size=2, max_size=12),
)
def test_a_rigid_motion_is_found_again(x: float, y: float, theta: float, points: list[tuple[float, float]]) -> None:
    motion = SE2(x, y, theta)
    cloud: Array = np.array(points)
    found = rigid_fit(cloud, motion.apply_all(cloud))
    assert np.abs(found.apply_all(cloud) - motion.apply_all(cloud)).max() < 1e-6


def test_the_true_meet_point_is_seen_from_the_true_pose() -> None:
    node = NodeView(NodeKind.MEET_POINT, 3.0, 4.0, 1.2, (0.0, 2.0, 4.0))
    base_in_odom, base_in_map = SE2(2.0, 4.0, math.pi / 2.0), SE2(10.0, 10.0, math.pi)
    # One metre to the right of the robot in odom: one metre to the right of it, facing -x, in map.
    assert true_meet_point(base_in_map, base_in_odom, node) == pytest.approx((10.0, 11.0))
    frame = edge_frame_in_map((10.0, 11.0), (10.0, 31.0))
    assert frame.apply(20.0, 0.0) == pytest.approx((10.0, 31.0))
