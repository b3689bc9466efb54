"""The sonar keeps what its model promises: who answers, from where, how exactly, how often."""

import dataclasses
import math

import numpy as np
import pytest
import shapely

from hslam_sim.sonar import SCOUT_FIRING_ORDER, SonarSimulator
from hslam_sim.sonar_configuration import SonarConfiguration
from hslam_sim.wall_index import WallIndex
from hslam_sim.world import World
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING

EXACT = SonarConfiguration().noise_free()
INCH = 0.0254
FORWARD = 0
"""Number of the ping that fires the forward sonar."""


def sonar_in(space: shapely.Geometry, config: SonarConfiguration) -> SonarSimulator:
    """Return a seeded sonar in a floor without landmarks."""
    assert isinstance(space, shapely.Polygon)
    inside = space.representative_point()
    walls = World("test", space, SE2(inside.x, inside.y), np.empty((0, 2))).walls
    return SonarSimulator(walls, WallIndex(walls, 7.0), SCOUT_RING, config, np.random.default_rng(7))


def hall(config: SonarConfiguration) -> SonarSimulator:
    """Return a sonar in a hall of 40 m x 40 m around the origin, too large to see two walls at once."""
    return sonar_in(shapely.box(-20, -20, 20, 20), config)


def facing_wall(distance_m: float, angle: float) -> SE2:
    """Return the pose whose forward sonar is ``distance_m`` from the hall's east wall and ``angle`` off its normal."""
    mount = SCOUT_RING.mount_radius_m
    return SE2(20 - distance_m - mount * math.cos(angle), -mount * math.sin(angle), angle)


def readings(sonar: SonarSimulator, pose: SE2, count: int) -> list[float]:
    """Return ``count`` readings of the forward sonar."""
    return [sonar.ping(FORWARD, 0, pose).range_m for _ in range(count)]


@pytest.mark.parametrize(
    ("degrees", "beyond"),
    [(0, 0.0), (14, 0.0), (25, 10.0), (39, 24.0)],
)
def test_a_flat_wall_answers_with_the_nearest_ray_near_normal_incidence(degrees: int, beyond: float) -> None:
    """Inside the cone the perpendicular counts, beyond it the cone's rim."""
    for sign in (-1, 1):
        (reading,) = readings(hall(EXACT), facing_wall(2.0, sign * math.radians(degrees)), 1)
        assert reading == pytest.approx(2.0 / math.cos(math.radians(beyond)), rel=1e-3)


def test_an_oblique_wall_is_heard_less_and_less_and_then_never() -> None:
    """Between sure and last incidence at the cone's rim the rate falls from all to none."""
    quiet = dataclasses.replace(SonarConfiguration(), spurious_probability=0.0, missing_probability=0.0)
    rates = [
        np.isfinite(readings(hall(quiet), facing_wall(2.0, math.radians(degrees)), 300)).mean()
        for degrees in (39, 42.5, 46)
    ]
    assert rates[0] == 1.0
    assert rates[1] == pytest.approx(0.5, abs=0.1)
    assert rates[2] == 0.0


def test_an_oblique_wall_hides_what_stands_behind_it() -> None:
    """A slanted board gives no echo of its own and blocks the wall behind it."""
    room = shapely.box(-20, -20, 20, 20)
    board = shapely.LineString([(17.0, -3.0), (19.0, 3.0)]).buffer(0.02, cap_style="flat")
    slanted = shapely.LineString([(16.0, -3.0), (19.5, 3.0)]).buffer(0.02, cap_style="flat")
    pose = facing_wall(4.0, 0.0)
    assert readings(sonar_in(room.difference(board), EXACT), pose, 1)[0] < 4.0
    flat_turned = shapely.affinity.rotate(slanted, -15.0)
    assert readings(sonar_in(room.difference(flat_turned), EXACT), pose, 1)[0] == math.inf


@pytest.mark.parametrize("degrees", [34, 45, 56])
def test_a_concave_corner_answers_from_anywhere_in_the_cone(degrees: int) -> None:
    """Both walls are too oblique, the corner sends the sound back."""
    axis = math.radians(degrees)
    pose = SE2(20 - 4.0 * math.cos(math.radians(45)), 20 - 4.0 * math.sin(math.radians(45)), axis)
    face = (pose.x + SCOUT_RING.mount_radius_m * math.cos(axis), pose.y + SCOUT_RING.mount_radius_m * math.sin(axis))
    # The walls answer at normal incidence only, so that nothing but the corner is left.
    (reading,) = readings(hall(dataclasses.replace(EXACT, sure_incidence=0.01, last_incidence=0.01)), pose, 1)
    assert reading == pytest.approx(math.dist(face, (20, 20)), abs=1e-9)


def test_a_convex_edge_answers_sometimes_and_only_from_near() -> None:
    """A pillar's edge seen diagonally is heard at its chance within its reach, and not beyond."""
    pillar = shapely.affinity.rotate(shapely.box(-0.5, -0.5, 0.5, 0.5), 45)
    config = dataclasses.replace(
        SonarConfiguration(), spurious_probability=0.0, missing_probability=0.0, noise_fraction=0.0
    )
    sonar = sonar_in(shapely.box(-20, -20, 20, 20).difference(pillar), config)
    mount, edge_x = SCOUT_RING.mount_radius_m, math.sqrt(0.5)
    near = np.array(readings(sonar, SE2(edge_x + mount + 1.0, 0.0, math.pi), 1000))
    heard = np.isfinite(near)
    assert heard.mean() == pytest.approx(config.edge_probability, abs=0.05)
    assert near[heard] == pytest.approx(1.0, abs=INCH)
    assert not np.isfinite(readings(sonar, SE2(edge_x + mount + 2.5, 0.0, math.pi), 200)).any()


def test_side_lobes_hear_a_near_wall_the_main_lobe_cannot() -> None:
    """With a sharp main lobe, a wall 28 deg off axis answers weakly at its perpendicular distance."""
    config = dataclasses.replace(EXACT, sure_incidence=0.05, last_incidence=0.05, side_lobe_probability=0.4)
    angle = math.radians(28.0)
    near = np.array(readings(hall(config), facing_wall(1.0, angle), 1000))
    heard = np.isfinite(near)
    ends = math.cos(SCOUT_RING.cone_half_angle), math.cos(config.side_lobe_angle)
    expected = 0.4 * (math.cos(angle) - ends[1]) / (ends[0] - ends[1])
    assert heard.mean() == pytest.approx(expected, abs=0.05)
    assert near[heard] == pytest.approx(1.0, abs=1e-9)
    assert not np.isfinite(readings(hall(config), facing_wall(2.0, angle), 200)).any()


def test_noise_rounding_spurious_and_missing_readings_have_their_stated_size() -> None:
    """One per cent noise, whole inches, one per cent short, two per cent silent."""
    config = SonarConfiguration()
    found = np.array(readings(hall(config), facing_wall(4.0, 0.0), 6000))
    assert np.isinf(found).mean() == pytest.approx(config.missing_probability, abs=0.006)
    heard = found[np.isfinite(found)]
    assert np.abs(heard / INCH - np.round(heard / INCH)).max() < 1e-9
    short = heard < 4.0 * 0.94
    assert short.mean() == pytest.approx(config.spurious_probability, abs=0.005)
    # Cutting to whole inches takes half an inch on average and adds its own spread.
    assert heard[~short].mean() == pytest.approx(4.0 - INCH / 2, abs=0.003)
    assert heard[~short].std() == pytest.approx(math.hypot(0.04, INCH / math.sqrt(12)), rel=0.05)


def test_readings_keep_to_the_board_s_range() -> None:
    """Six inches are the least it says; what is farther than 255 inches counts as nothing heard."""
    assert readings(hall(EXACT), facing_wall(0.03, 0.0), 1) == [SCOUT_RING.range_min_m]
    assert readings(hall(EXACT), facing_wall(6.49, 0.0), 1) == [math.inf]
    assert readings(hall(EXACT), facing_wall(6.47, 0.0), 1)[0] == pytest.approx(6.47)


def test_the_ring_fires_in_the_scout_s_order() -> None:
    """Sixteen pings use each sonar once, in the drivers' order."""
    sonar = hall(EXACT)
    fired = [sonar.ping(k, 0, SE2()).sensor for k in range(32)]
    assert fired == [*SCOUT_FIRING_ORDER, *SCOUT_FIRING_ORDER]
    assert sorted(SCOUT_FIRING_ORDER) == list(range(16))
