"""The landmark sensor sees what is in sight, as exactly and as often as it says."""

import math

import numpy as np
import pytest
import shapely

from hslam_sim.landmark_sensor import LandmarkConfiguration, LandmarkSensor
from hslam_sim.wall_index import WallIndex
from hslam_sim.world import World
from hslam_types.se2 import SE2, Array, wrap

EXACT = LandmarkConfiguration().noise_free()
BEND = shapely.Polygon(
    [(0, 0), (8, 0), (8, 8), (6, 8), (6, 2), (0, 2)], [[(2.9, 0.9), (3.1, 0.9), (3.1, 1.1), (2.9, 1.1)]]
)
"""An L-shaped corridor with a pillar."""


def boxes(space: shapely.Polygon, spacing_m: float) -> Array:
    """Return points at equal distances along the walls."""
    count = int(space.boundary.length / spacing_m)
    parts = [space.exterior, *space.interiors]
    points = [p.interpolate(s) for p in parts for s in np.arange(0.31, p.length, space.boundary.length / count)]
    return np.array([(p.x, p.y) for p in points])


def sensor(landmarks: Array, config: LandmarkConfiguration, space: shapely.Polygon = BEND) -> LandmarkSensor:
    """Return a seeded sensor."""
    walls = WallIndex(World("bend", space, SE2(1.0, 1.0, 0.0), landmarks).walls, 7.0)
    return LandmarkSensor(landmarks, walls, config, np.random.default_rng(3))


@pytest.mark.parametrize("pose", [SE2(1.0, 0.6, 0.3), SE2(5.0, 1.5, -2.0), SE2(7.0, 5.0, 3.0)])
def test_exactly_the_boxes_in_line_of_sight_and_range_are_seen(pose: SE2) -> None:
    """Every box seen, and no other, has a free line to the sensor."""
    landmarks = boxes(BEND, 0.37)
    view = sensor(landmarks, EXACT).look(5, pose)
    seen = {
        (round(x, 6), round(y, 6))
        for x, y in (
            pose.apply(s.range_m * math.cos(s.bearing), s.range_m * math.sin(s.bearing)) for s in view.sightings
        )
    }
    expected = set()
    for x, y in landmarks.tolist():
        reach = math.dist((x, y), pose[:2])
        # The line ends just before the box, which stands proud of its wall.
        share = (reach - 0.05) / reach
        end = pose.x + share * (x - pose.x), pose.y + share * (y - pose.y)
        if reach < EXACT.range_max_m and BEND.covers(shapely.LineString([pose[:2], end])):
            expected.add((round(x, 6), round(y, 6)))
    assert seen == expected
    assert 5 < len(seen) < len(landmarks)
    assert (view.stamp_ns, view.range_max_m) == (5, EXACT.range_max_m)


def test_noise_has_the_size_each_sighting_states() -> None:
    """Errors divided by the stated deviations have unit spread and no bias."""
    landmarks = np.array([[4.0, 0.0]])
    config = LandmarkConfiguration(missed_probability=0.0, clutter_probability=0.0)
    looker, pose = sensor(landmarks, config), SE2(1.0, 1.2, 0.7)
    true_range, true_bearing = math.hypot(3.0, 1.2), math.atan2(-1.2, 3.0) - 0.7
    sightings = [looker.look(0, pose).sightings[0] for _ in range(3000)]
    ranges = np.array([(s.range_m - true_range) / s.range_std_m for s in sightings])
    bearings = np.array([wrap(s.bearing - true_bearing) / s.bearing_std for s in sightings])
    for errors in (ranges, bearings):
        assert abs(errors.mean()) < 0.06
        assert errors.std() == pytest.approx(1.0, abs=0.05)


def test_boxes_are_missed_and_invented_at_their_rates() -> None:
    """One in ten goes unseen; one look in five holds a false one, anywhere within range."""
    landmarks = np.array([[4.0, 0.0], [1.5, 0.0], [1.0, 2.0]])
    config = LandmarkConfiguration(range_std_m=0.0, range_std_fraction=0.0, bearing_std=0.0)
    looker, pose = sensor(landmarks, config), SE2(2.0, 1.6, 0.0)
    true = sorted(math.dist(p, pose[:2]) for p in landmarks.tolist())
    looks = [[s.range_m for s in looker.look(0, pose).sightings] for _ in range(3000)]
    genuine = sum(any(abs(r - t) < 1e-9 for t in true) for look in looks for r in look)
    false = [r for look in looks for r in look if all(abs(r - t) > 1e-9 for t in true)]
    assert genuine / (3 * len(looks)) == pytest.approx(1.0 - config.missed_probability, abs=0.01)
    assert len(false) / len(looks) == pytest.approx(config.clutter_probability, abs=0.02)
    assert max(false) <= config.range_max_m


def test_the_order_of_sightings_tells_nothing() -> None:
    """Shuffled landmarks give the same view but for the draws: sightings come by bearing."""
    landmarks = boxes(BEND, 0.5)
    shuffled = np.random.default_rng(1).permutation(landmarks)
    pose = SE2(5.0, 1.0, 1.0)
    one, other = sensor(landmarks, EXACT).look(0, pose), sensor(shuffled, EXACT).look(0, pose)
    assert one == other
    assert list(one.sightings) == sorted(one.sightings, key=lambda s: s.bearing)
