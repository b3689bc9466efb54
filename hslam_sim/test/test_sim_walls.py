"""Ray casting and clearance against an independent geometry library."""

import math

import numpy as np
import pytest
import shapely

from hslam_sim.wall_index import WallIndex
from hslam_sim.world import World
from hslam_types.se2 import SE2

OUTLINE = [(0, 0), (9, 0), (9, 4), (5, 3), (4, 7), (0, 6)]
ISLAND = [(1.5, 1.5), (2.5, 1.2), (2.2, 2.8)]


def ragged_world() -> World:
    """Return a floor with many short wall pieces, so that culling is at work."""
    fine = shapely.segmentize(shapely.Polygon(OUTLINE, [ISLAND]), 0.1)
    return World("ragged", fine, SE2(0.5, 0.5, 0.0), np.empty((0, 2)))


@pytest.mark.parametrize("at", [(0.5, 0.5), (3.0, 3.0), (8.5, 0.2)])
def test_a_ray_ends_where_shapely_says(at: tuple[float, float]) -> None:
    """The distance of every ray is that of the first crossing with the outline."""
    world = ragged_world()
    near = WallIndex(world.walls, 20.0).near(*at)
    angles = [0.1 + k * math.tau / 50 for k in range(50)]
    rays = np.array([(math.cos(a), math.sin(a)) for a in angles])
    distance, cosine = near.facing(*at, 20.0).cast(*at, rays[:, 0], rays[:, 1])
    boundary = world.free_space.boundary
    for (dx, dy), found in zip(rays.tolist(), distance.tolist(), strict=True):
        ray = shapely.LineString([at, (at[0] + 20 * dx, at[1] + 20 * dy)])
        assert found == pytest.approx(boundary.intersection(ray).distance(shapely.Point(at)), abs=1e-9)
    assert (cosine > 0.0).all()


def test_a_wedge_keeps_every_wall_a_ray_inside_it_hits() -> None:
    """Sorting walls out by the beam changes no distance."""
    at = (3.0, 3.0)
    facing = WallIndex(ragged_world().walls, 20.0).near(*at).facing(*at, 20.0)
    for k in range(24):
        axis = k * math.tau / 24
        angles = [axis + a for a in (-0.25, -0.1, 0.0, 0.17, 0.25)]
        x, y = np.array([math.cos(a) for a in angles]), np.array([math.sin(a) for a in angles])
        wedge = facing.within_wedge(*at, (x[0], y[0]), (x[-1], y[-1]))
        assert len(wedge.length) < len(facing.length) / 2
        np.testing.assert_array_equal(wedge.cast(*at, x[1:-1], y[1:-1])[0], facing.cast(*at, x[1:-1], y[1:-1])[0])


def test_clearance_is_the_distance_to_the_outline() -> None:
    """Clearance agrees with the world's own."""
    world = ragged_world()
    index = WallIndex(world.walls, 2.0)
    for x, y in [(0.5, 0.5), (2.6, 2.0), (8.0, 3.0), (4.2, 6.9)]:
        assert index.near(x, y).clearance(x, y) == pytest.approx(world.clearance(x, y), abs=1e-12)


def test_a_cell_holds_all_walls_in_reach_however_far_the_world_extends() -> None:
    """Walls beyond reach are left out, walls within it never."""
    index = WallIndex(ragged_world().walls, 1.0)
    for x, y in [(0.99, 0.99), (0.01, 5.9), (4.5, 4.9)]:
        near = index.near(x, y)
        assert len(near.length) < len(index.walls.length)
        whole = index.walls.clearance(x, y)
        assert whole < 1.0
        assert near.clearance(x, y) == whole
