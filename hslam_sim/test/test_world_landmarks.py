"""Landmarks on the walls: where, how many, how irregular, and by which seed."""

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist, squareform

from hslam_sim.wall_landmarks import WallLandmarks, place
from hslam_sim.worlds import load_world


def test_one_seed_gives_one_layout_and_another_a_different_one() -> None:
    first, again, other = (load_world("small_world", landmark_seed=seed).landmarks for seed in (3, 3, 4))
    assert np.array_equal(first, again)
    assert first.shape != other.shape or not np.allclose(first, other)


def test_the_papers_floor_has_about_one_box_a_metre_in_uneven_gaps() -> None:
    world = load_world("wean_hall_6")
    assert 0.85 < len(world.landmarks) / world.free_space.boundary.length < 1.05
    apart = squareform(pdist(world.landmarks))
    np.fill_diagonal(apart, np.inf)
    nearest = apart.min(axis=1)
    assert nearest.min() >= 0.6
    assert nearest.std() > 0.1


@settings(max_examples=40, deadline=None)
@given(
    width=st.floats(1.0, 20.0),
    height=st.floats(1.0, 20.0),
    per_metre=st.floats(0.05, 1.4),
    gap=st.floats(0.1, 2.0),
    seed=st.integers(0, 1000),
)
def test_boxes_stand_on_walls_inside_and_apart(
    width: float, height: float, per_metre: float, gap: float, seed: int
) -> None:
    hole = shapely.box(0.4 * width, 0.4 * height, 0.6 * width, 0.6 * height)
    space = shapely.box(0.0, 0.0, width, height).difference(hole)
    assert isinstance(space, shapely.Polygon)
    config = WallLandmarks(per_metre=per_metre, least_gap_m=gap)
    points = place(space, config, np.random.default_rng(seed))
    assert shapely.contains_xy(space, points[:, 0], points[:, 1]).all()
    off_wall = shapely.distance(space.boundary, shapely.points(points))
    assert (off_wall <= config.standoff_m + 1e-9).all()
    if len(points) > 1:
        assert pdist(points).min() >= gap


def test_density_nought_means_none() -> None:
    assert place(shapely.box(0, 0, 5, 5), WallLandmarks(per_metre=0.0), np.random.default_rng(0)).shape == (0, 2)
