"""Corners and ends are told where they are, shadows are not, and each as well as it is known."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanned_walls import Wall, box, places, scan_of, sorted_rows

from hslam_landmarks.config import ScanLandmarksConfig
from hslam_landmarks.scan_landmarks import look
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import LandmarkView, RangeScan

CONFIG = ScanLandmarksConfig(range_max_m=12.0)
ROOM = box(-3.0, -2.0, 4.0, 2.5)
ROOM_CORNERS = np.array([[-3.0, -2.0], [-3.0, 2.5], [4.0, -2.0], [4.0, 2.5]])


def seen(walls: list[Wall], base: SE2 = SE2(), config: ScanLandmarksConfig = CONFIG) -> LandmarkView:  # noqa: B008
    return look(scan_of(walls, base), config)


@given(st.floats(-2.2, 3.2), st.floats(-1.2, 1.7), st.floats(-math.pi, math.pi))
def test_a_room_has_its_corners_from_wherever_it_is_seen(x: float, y: float, heading: float) -> None:
    base = SE2(x, y, heading)
    found = sorted_rows(places(seen(ROOM, base), base))
    assert found == pytest.approx(ROOM_CORNERS, abs=0.01)


@given(st.integers(0, 359))
def test_it_is_all_one_where_a_full_circle_begins(turned: int) -> None:
    walls = ROOM + box(1.0, 0.5, 2.0, 1.2)
    plain = scan_of(walls)
    first = plain.first_bearing + turned * plain.bearing_step
    rolled = dataclasses.replace(plain, first_bearing=first, ranges=np.roll(plain.ranges, -turned))
    assert sorted_rows(places(look(rolled, CONFIG))) == pytest.approx(
        sorted_rows(places(look(plain, CONFIG))), abs=1e-6
    )


def test_a_screen_before_a_wall_has_two_ends_and_throws_no_landmark_on_it() -> None:
    screen = (2.0, -0.7, 2.0, 0.8)
    found = sorted_rows(places(seen([*ROOM, screen])))
    ends = found[(found[:, 0] > 1.5) & (found[:, 0] < 2.5)]
    assert ends == pytest.approx(np.array([[2.0, -0.7], [2.0, 0.8]]), abs=0.03)
    assert len(found) == len(ends) + len(ROOM_CORNERS)


def test_a_doorway_shows_its_jambs_and_no_shadow_of_them() -> None:
    # A wall with a doorway from y = 0.2 to y = 1.2, and a wall of the room behind it.
    walls = [(2.0, -4.0, 2.0, 0.2), (2.0, 1.2, 2.0, 4.0), (5.0, -4.0, 5.0, 4.0), *box(-2.0, -4.0, 5.0, 4.0)[::2]]
    found = places(seen(walls))
    inside = found[(np.abs(found[:, 1]) < 3.9)]
    assert sorted_rows(inside) == pytest.approx(np.array([[2.0, 0.2], [2.0, 1.2]]), abs=0.03)


def test_where_no_light_comes_back_there_is_no_end() -> None:
    wall_of_glass_beside = [(2.0, -3.0, 2.0, 0.5)]
    assert seen(wall_of_glass_beside).sightings == ()


def test_the_last_beam_of_a_view_is_no_end() -> None:
    assert look(scan_of(ROOM, view=math.radians(40.0), beams=80), CONFIG).sightings == ()


def test_a_silent_beam_in_a_wall_is_no_end() -> None:
    scan = scan_of(ROOM)
    ranges = scan.ranges.copy()
    ranges[[20, 100, 101, 200, 290]] = [np.inf, np.nan, -np.inf, np.inf, np.inf]
    found = places(look(dataclasses.replace(scan, ranges=ranges), CONFIG))
    assert sorted_rows(found) == pytest.approx(ROOM_CORNERS, abs=0.02)


def test_a_bend_is_no_corner() -> None:
    bend = [(2.0, -3.0, 2.0, 0.0), (2.0, 0.0, 1.0, 3.0)]
    assert not any(abs(s.bearing) < 0.3 for s in seen(bend).sightings)


def test_a_landmark_is_told_from_base_link_wherever_the_scanner_is_mounted() -> None:
    mounted = SE2(0.3, -0.2, 2.0)
    found = places(look(scan_of(ROOM, sensor_in_base=mounted), CONFIG))
    assert sorted_rows(found) == pytest.approx(ROOM_CORNERS, abs=0.01)


def test_what_is_farther_than_asked_for_is_not_told() -> None:
    near = seen(ROOM, config=dataclasses.replace(CONFIG, range_max_m=4.0))
    assert near.range_max_m == 4.0
    assert sorted(s.range_m for s in near.sightings) == pytest.approx(
        [math.hypot(3.0, 2.0), math.hypot(3.0, 2.5)], abs=0.01
    )


def test_of_two_at_one_place_one_is_told() -> None:
    thin = [*ROOM, (2.0, -0.7, 2.0, 0.8), (2.0, 0.8, 2.1, 0.8)]
    config = dataclasses.replace(CONFIG, least_gap_m=0.3)
    found = places(seen(thin, SE2(0.0, 0.0, 0.0), config))
    assert sum(math.dist(point, (2.05, 0.8)) < 0.25 for point in found.tolist()) == 1


def chi_of(scan: RangeScan, base: SE2, truth: np.ndarray, config: ScanLandmarksConfig) -> list[float]:
    """Return each sighting's squared error over its stated variances, against the nearest true landmark."""
    chis = []
    view = look(scan, config)
    for sighting, place in zip(view.sightings, places(view, base), strict=True):
        true = truth[np.argmin(np.hypot(*(truth - place).T))]
        x, y = base.inverse().apply(*true.tolist())
        off = wrap(math.atan2(y, x) - sighting.bearing) / sighting.bearing_std
        chis.append(((math.hypot(x, y) - sighting.range_m) / sighting.range_std_m) ** 2 + off**2)
    return chis


@pytest.mark.parametrize("noise_m", [0.005, 0.015, 0.03])
def test_corners_are_known_as_well_as_they_say(noise_m: float) -> None:
    rng = np.random.default_rng(3)
    config = dataclasses.replace(CONFIG, still_std_m=0.0, range_std_m=noise_m)
    chis: list[float] = []
    for _ in range(150):
        base = SE2(rng.uniform(-1.5, 2.5), rng.uniform(-1.0, 1.5), rng.uniform(-3.0, 3.0))
        chis += chi_of(scan_of(ROOM, base, noise=(noise_m, rng)), base, ROOM_CORNERS, config)
    assert len(chis) > 550
    assert 0.6 < float(np.mean(chis)) / 2.0 < 1.1  # the larger of stated and seen noise is taken: a little too careful
    assert float(np.mean(np.array(chis) > 11.8)) < 0.02


def test_ends_are_known_as_well_as_they_say() -> None:
    rng = np.random.default_rng(4)
    config = dataclasses.replace(CONFIG, still_std_m=0.0, range_std_m=0.01)
    screen = (1.0, -0.7, 1.0, 0.8)
    truth = np.concatenate((ROOM_CORNERS, [[1.0, -0.7], [1.0, 0.8]]))
    chis: list[float] = []
    for _ in range(300):
        base = SE2(rng.uniform(-2.5, 0.0), rng.uniform(-1.0, 1.5), rng.uniform(-3.0, 3.0))
        scan = scan_of([*ROOM, screen], base, noise=(0.01, rng))
        view = look(scan, config)
        near = [abs(place[0] - 1.0) < 0.3 for place in places(view, base)]
        chis += [chi for chi, is_end in zip(chi_of(scan, base, truth, config), near, strict=True) if is_end]
    assert len(chis) > 400
    assert 0.7 < float(np.mean(chis)) / 2.0 < 1.3


def test_a_look_says_what_the_scan_could_have_shown() -> None:
    half = np.full(181, 3.0)
    scan = RangeScan(0, SE2(0.2, 0.1, 0.3), -math.pi / 2.0, math.pi / 180.0, 0.15, 8.0, half)
    field = look(scan, ScanLandmarksConfig()).field
    assert field == pytest.approx((0.2, 0.1, 0.3 - math.pi / 2.0, 0.3 + math.pi / 2.0, 0.15))
    for beams in (360, 361):
        round_it = dataclasses.replace(scan, ranges=np.full(beams, 3.0))
        assert look(round_it, ScanLandmarksConfig()).field == (0.2, 0.1, 0.0, 0.0, 0.15)
    nothing = dataclasses.replace(scan, ranges=np.full(len(scan.ranges), math.inf))
    assert look(nothing, ScanLandmarksConfig()).field == field
    gap = look(dataclasses.replace(scan, ranges=np.full(350, 3.0)), ScanLandmarksConfig()).field
    assert (gap.bearing_to - gap.bearing_from) == pytest.approx(math.radians(349.0))
