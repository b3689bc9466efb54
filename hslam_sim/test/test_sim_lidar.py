"""The lidar against ray casting, wall by wall, and what its parameters do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hslam_sim.lidar import Lidar
from hslam_sim.lidar_configuration import LidarConfiguration
from hslam_sim.wall_index import Walls
from hslam_sim.worlds import load_world
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import RangeScan

WORLD = load_world("wean_hall_6")
EXACT = LidarConfiguration(beams=180, noise_m=0.0, missing_probability=0.0)


def scanned(config: LidarConfiguration, pose: SE2, segments: Array = WORLD.walls, seed: int = 0) -> RangeScan:
    """Return a scan of the first look of a seeded lidar."""
    return Lidar(segments, config, np.random.default_rng(seed)).scan(0, pose)


@settings(max_examples=40, deadline=None)
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-math.pi, math.pi), st.floats(1.0, math.tau))
def test_ranges_are_those_of_casting_every_ray_at_every_wall(x: float, y: float, turn: float, view: float) -> None:
    config = LidarConfiguration(beams=97, field_of_view=view, noise_m=0.0, missing_probability=0.0)
    pose = SE2(WORLD.start.x + x, WORLD.start.y + y, turn)
    scan = scanned(config, pose)
    angles = scan.bearings + turn
    cast, _ = Walls.from_segments(WORLD.walls).cast(pose.x, pose.y, np.cos(angles), np.sin(angles))
    cast[cast > config.range_max_m] = np.inf
    # A ray along a wall's end may meet it or not, by the last bit of its direction.
    assert np.count_nonzero(~np.isclose(cast, scan.ranges, rtol=0.0, atol=1e-9)) <= 1


def test_beams_span_the_field_of_view_once() -> None:
    full, half = EXACT, LidarConfiguration(beams=181, field_of_view=math.pi)
    assert full.bearing_step * full.beams == pytest.approx(math.tau)
    assert half.bearing_step == pytest.approx(math.pi / 180)
    assert scanned(half, WORLD.start).bearings[[0, -1]] == pytest.approx([-math.pi / 2, math.pi / 2])


def test_a_mounting_ahead_measures_from_there() -> None:
    pose = SE2(WORLD.start.x, WORLD.start.y, 0.3)
    ahead = scanned(LidarConfiguration(beams=180, noise_m=0.0, missing_probability=0.0, forward_m=0.1), pose)
    there = scanned(EXACT, pose @ SE2(0.1, 0.0, 0.0))
    assert np.array_equal(ahead.ranges, there.ranges)
    assert ahead.sensor_in_base == SE2(0.1, 0.0, 0.0)


def test_noise_has_the_stated_deviation() -> None:
    clean = scanned(EXACT, WORLD.start).ranges
    noisy = scanned(LidarConfiguration(beams=180, noise_m=0.03, missing_probability=0.0), WORLD.start).ranges
    both = np.isfinite(clean) & np.isfinite(noisy)
    assert np.std(noisy[both] - clean[both]) == pytest.approx(0.03, rel=0.2)


def test_dark_walls_do_not_answer_and_still_hide_what_is_behind() -> None:
    # Two parallel walls, both facing the scanner, which sits below them.
    near, far = [2.0, 1.0, -2.0, 1.0], [2.0, 2.0, -2.0, 2.0]
    ahead = LidarConfiguration(beams=1, field_of_view=0.1, noise_m=0.0, missing_probability=0.0, dark_share=1.0)
    silent = scanned(ahead, SE2(0.0, 0.0, math.pi / 2), np.array([near, far]))
    assert np.isinf(silent.ranges).all()


def test_glass_shows_what_is_behind_it() -> None:
    walls = np.array([[2.0, 1.0, -2.0, 1.0], [2.0, 2.0, -2.0, 2.0]])
    for seed in range(20):
        config = LidarConfiguration(
            beams=2, field_of_view=0.1, noise_m=0.0, missing_probability=0.0, glass_share=0.5, patch_m=4.0
        )
        ranges = scanned(config, SE2(0.0, 0.0, math.pi / 2), walls, seed).ranges
        if ranges[0] == pytest.approx(2.0, abs=0.01):
            return
    pytest.fail("in twenty draws of glass no beam went through the nearer wall to the farther")


def test_too_near_and_too_far_is_no_answer() -> None:
    walls = np.array([[5.0, 4.0, -5.0, 4.0]])
    config = LidarConfiguration(beams=1, field_of_view=0.1, noise_m=0.0, missing_probability=0.0, range_max_m=3.9)
    assert np.isinf(scanned(config, SE2(0.0, 0.0, math.pi / 2), walls).ranges).all()
    assert np.isinf(scanned(config, SE2(0.0, 3.95, math.pi / 2), walls).ranges).all()


def test_missing_beams_are_as_many_as_stated() -> None:
    config = LidarConfiguration(beams=3600, noise_m=0.0, missing_probability=0.1)
    clean = scanned(LidarConfiguration(beams=3600, noise_m=0.0, missing_probability=0.0), WORLD.start).ranges
    missed = np.isfinite(clean) & np.isinf(scanned(config, WORLD.start).ranges)
    assert np.count_nonzero(missed) / np.count_nonzero(np.isfinite(clean)) == pytest.approx(0.1, abs=0.03)
