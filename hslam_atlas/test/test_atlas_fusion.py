"""A confirmed drive updates the stored edge-map."""

import math

import numpy as np
from test_atlas_alignment import drives

from hslam_atlas.config import AtlasConfig
from hslam_atlas.fusion import fuse
from hslam_atlas.map_match import match_edges
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2

PRIOR = np.diag([0.0072, 0.0072, math.radians(0.3) ** 2])


def fused(maps: list[EdgeMap]) -> EdgeMap:
    """Return the first map updated by the others."""
    known = maps[0]
    for drives_before, candidate in enumerate(maps[1:], start=1):
        match = match_edges(known, candidate, SE2(), PRIOR, 0.085, AtlasConfig())
        known, _ = fuse(known, candidate, match.alignment, drives_before)
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
    """Over many edges: the error of the mean of four drives is well below that of one."""
    single, joined = [], []
    for seed in range(12):
        maps = drives(4, 1000 + 50 * seed)
        single.append(abs(maps[0].terminal_x - 36.0))
        joined.append(abs(fused(maps).terminal_x - 36.0))
    assert np.mean(joined) < 0.8 * np.mean(single)


def test_clutter_does_not_pile_up() -> None:
    maps = drives(8, 300)
    assert fused(maps).size < 1.25 * np.mean([m.size for m in maps])


def test_frame_moves_by_its_share_of_the_offset() -> None:
    first, second = drives(2, 140)
    match = match_edges(first, second, SE2(), PRIOR, 0.085, AtlasConfig())
    _, moved = fuse(first, second, match.alignment, 1)
    assert math.isclose(moved.x, match.alignment.offset.x / 2.0)
    assert math.isclose(moved.y, match.alignment.offset.y / 2.0)
    assert abs(moved.theta) < math.radians(1.0)
