"""A confirmed drive updates the stored edge-map."""

import math
from dataclasses import replace

import numpy as np
import pytest
from test_atlas_alignment import FLOOR, drives, drives_with_truth

from hslam_atlas.config import AtlasConfig
from hslam_atlas.fusion import _turned, fuse
from hslam_atlas.map_match import match_edges
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2

PRIOR = np.diag([0.0072, 0.0072, math.radians(0.3) ** 2])


def fused(maps: list[EdgeMap]) -> EdgeMap:
    """Return the first map updated by the others."""
    known = maps[0]
    for drives_before, candidate in enumerate(maps[1:], start=1):
        match = match_edges(known, candidate, SE2(), PRIOR, 0.085, AtlasConfig())
        known, _ = fuse(known, candidate, match.alignment, (drives_before, 1), forget_below=4)
    return known


def test_fused_map_keeps_the_form_of_an_edge_map() -> None:
    maps = drives(4, 100)
    known = fused(maps)
    assert known.covariance.shape == (2 + 2 * known.size, 2 + 2 * known.size)
    np.testing.assert_allclose(known.covariance, known.covariance.T, atol=1e-12)
    assert np.linalg.eigvalsh(known.covariance)[0] > -1e-9
    assert np.all(known.covariance[1] == 0.0)
    assert len(known.sightings) == known.size


def test_each_drive_makes_the_map_surer() -> None:
    maps = drives(3, 120)
    variances = [maps[0].covariance[0, 0], fused(maps[:2]).covariance[0, 0], fused(maps).covariance[0, 0]]
    assert variances[0] > variances[1] > variances[2]


def test_fusing_brings_the_length_nearer_to_the_truth() -> None:
    """Over many edges: after four drives the first one's length is known better than after it alone."""
    single, joined = [], []
    for seed in range(12):
        found = drives_with_truth(4, 1000 + 50 * seed)
        _, _, true_m = found[0]
        single.append(abs(found[0][0].terminal_x - true_m))
        joined.append(abs(fused([edge_map for edge_map, _, _ in found]).terminal_x - true_m))
    assert np.mean(joined) < 0.8 * np.mean(single)


def test_clutter_does_not_pile_up() -> None:
    maps = drives(8, 300)
    assert fused(maps).size < 1.25 * np.mean([m.size for m in maps])


def test_frame_stays_with_the_first_drive() -> None:
    """A fused map lies about the first drive's meet points as surely as its covariance says, whatever the others'."""
    nees: list[float] = []
    for seed in range(8):
        found = drives_with_truth(4, 2000 + 50 * seed)
        known = fused([edge_map for edge_map, _, _ in found])
        truth = found[0][1].inverse().apply_all(FLOOR.landmarks)
        for k, landmark in enumerate(known.landmarks):
            error = min(landmark - truth, key=lambda e: float(e @ e))
            if float(error @ error) < 0.3**2:  # else clutter
                block = known.covariance[2 + 2 * k : 4 + 2 * k, 2 + 2 * k : 4 + 2 * k]
                nees.append(float(error @ np.linalg.solve(block, error)) / 2.0)
    assert 0.5 < np.mean(nees) < 1.5


def test_a_map_of_several_drives_weighs_as_much() -> None:
    known, candidate = drives(2, 100)
    match = match_edges(known, candidate, SE2(), PRIOR, 0.085, AtlasConfig())
    longer = replace(candidate, path_length_m=known.path_length_m + 4.0)
    joined, _ = fuse(known, longer, match.alignment, (1, 3), forget_below=4)
    assert joined.path_length_m == pytest.approx(known.path_length_m + 3.0)


def test_what_was_seen_stays_however_seldom_and_what_was_not_is_forgotten() -> None:
    """However few sightings the filter asks for, fusing asks no more of what a drive did see."""
    known, candidate = (replace(m, sightings=(2,) * m.size) for m in drives(2, 100))
    match = match_edges(known, candidate, SE2(), PRIOR, 0.085, AtlasConfig())
    pairs = len(match.alignment.pairs)
    assert 0 < pairs < known.size + candidate.size - pairs  # some of either kind
    joined, _ = fuse(known, candidate, match.alignment, (1, 1), forget_below=4)
    assert joined.sightings == (4,) * pairs + (2,) * (candidate.size - pairs)
    all_kept, _ = fuse(known, candidate, match.alignment, (1, 1), forget_below=0)
    assert all_kept.size == known.size + candidate.size - pairs


@pytest.mark.parametrize("terminal", [(8.0, 0.4), (0.2, 0.1)])
def test_the_terminal_keeps_no_y_however_near_it_is(terminal: tuple[float, float]) -> None:
    points = np.array([terminal, (1.0, 2.0)])
    turned, covariance, phi = _turned(points, np.diag([0.04, 0.03, 0.02, 0.01]))
    assert turned[0, 1] == 0.0
    assert not covariance[1].any()
    assert not covariance[:, 1].any()
    assert math.hypot(*turned[1]) == pytest.approx(math.sqrt(5.0))
    assert (phi == 0.0) == (terminal[0] < 0.5)
