"""Which landmarks are believed: clutter is not, removed ones no longer, hidden ones still."""

import math

import numpy as np
import pytest

from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_ekf.synthetic_drive import DriveErrors, corridor_landmarks, drive
from hslam_ekf.traversal import Traversal
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import LandmarkSighting, LandmarkView, OdometrySample

PATH = np.array([[0.0, 0.0], [30.0, 0.0]])


def mapped(seed: int, errors: DriveErrors) -> tuple[EdgeMap, Array]:
    """Return the edge-map of a straight drive and the distances of its landmarks (rows) to the true ones."""
    rng = np.random.default_rng(seed)
    landmarks = corridor_landmarks(PATH, rng)
    server = EkfServer()
    maps = [m for s in drive(PATH, landmarks, errors, rng) for m in server.step(s.odom, s.view, s.events).edge_maps]
    return maps[0], np.linalg.norm(maps[0].landmarks[:, None] - landmarks[None], axis=2)


@pytest.mark.parametrize("seed", range(3))
def test_a_tenth_of_clutter_leaves_few_false_landmarks(seed: int) -> None:
    edge_map, distance = mapped(seed, DriveErrors(clutter=0.1))
    false = int((distance.min(axis=1) > 0.3).sum())
    assert false <= 1
    assert edge_map.size - false == distance.shape[1]


def look(base: SE2, landmarks: list[tuple[float, float]]) -> LandmarkView:
    """Return a noise-free look at landmarks given in the frame of ``base``'s pose."""
    seen = [base.inverse().apply(*point) for point in landmarks]
    return LandmarkView(
        0, 6.0, tuple(LandmarkSighting(math.hypot(x, y), math.atan2(y, x), 0.05, 0.02) for x, y in seen)
    )


def test_a_landmark_seen_past_is_dropped_and_a_hidden_one_is_kept() -> None:
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    removed, far, hidden, beside = (3.0, 0.0), (5.0, 0.05), (0.0, 4.0), (-3.0, -2.0)
    for _ in range(6):
        traversal.look(look(SE2(), [removed, far, hidden, beside]))
    assert len(traversal.filter.landmarks) == 4
    for _ in range(30):
        traversal.look(look(SE2(), [far, beside]))
    left = {(round(x), round(y)) for x, y in traversal.filter.landmarks.tolist()}
    assert left == {(5, 0), (0, 4), (-3, -2)}


def test_a_single_false_sighting_does_not_outlive_three_looks() -> None:
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    traversal.look(look(SE2(), [(3.0, 0.0), (2.0, 2.0)]))
    for expected in (2, 2, 1):
        traversal.look(look(SE2(), [(2.0, 2.0)]))
        assert len(traversal.filter.landmarks) == expected


def test_standing_still_costs_no_prediction() -> None:
    server = EkfServer()
    rng = np.random.default_rng(0)
    steps = drive(PATH, corridor_landmarks(PATH, rng), DriveErrors(), rng)[:20]
    for step in steps:
        server.step(step.odom, step.view, step.events)
    assert server.traversal is not None
    before = server.traversal.filter.covariance.copy()
    server.step(OdometrySample(steps[-1].odom.stamp_ns + 1, steps[-1].odom.base_in_odom), None, ())
    assert np.array_equal(server.traversal.filter.covariance, before)


def test_a_look_counts_for_the_landmarks_it_shows_whatever_is_out_of_range() -> None:
    """The first landmark is out of range, so those expected are numbered otherwise than all there are."""
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    traversal.look(look(SE2(), [(5.9, 0.0), (2.0, 2.0), (2.0, -2.0)]))
    traversal.advance(SE2(-1.0, 0.0, 0.0))
    for _ in range(5):
        traversal.look(look(SE2(-1.0, 0.0, 0.0), [(2.0, 2.0), (2.0, -2.0)]))
    assert traversal._evidence.sightings.tolist() == [1, 6, 6]
    assert traversal._evidence.misses.tolist() == [0, 0, 0]
