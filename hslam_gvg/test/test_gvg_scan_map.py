"""What a scan shows becomes walls and free space, and nothing else does."""

import dataclasses
import math

import numpy as np
import pytest
from drawn_scans import scan_of
from drawn_walls import CROSSING, T_JUNCTION, Wall
from hypothesis import given
from hypothesis import strategies as st

from hslam_gvg.ranging.scan_map import ScanMap
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import RangeScan

ROOM: tuple[Wall, ...] = ((-2, -2, 2, -2), (2, -2, 2, 2), (2, 2, -2, 2), (-2, 2, -2, -2))
CENTRE = SE2(0.3, 0.2, 0.4)
CORNER_CUT_M = 0.03
"""Two beams on either side of a corner are joined by a straight wall."""


def heard(*scans: tuple[RangeScan, SE2, float], config: ScanMapConfig | None = None) -> ScanMap:
    """Return the map after scans, each from a pose and at an odometer reading."""
    mapped = ScanMap(config or ScanMapConfig())
    for scan, pose, odometer_m in scans:
        mapped.hear(scan, pose, odometer_m)
    return mapped


def free(mapped: ScanMap, x: float, y: float) -> bool:
    """Whether a place is known to be free."""
    return bool(mapped.grid.is_free(np.array([x]), np.array([y]))[0])


def off_walls(points: Array, walls: tuple[Wall, ...]) -> float:
    """Return how far (m) the farthest of the points lies from all walls."""
    a, b = np.array(walls, dtype=np.float64)[:, :2], np.array(walls, dtype=np.float64)[:, 2:]
    along = b - a
    share = np.einsum("pij,ij->pi", points[:, None] - a, along) / np.einsum("ij,ij->i", along, along)
    foot = a + np.clip(share, 0.0, 1.0)[..., None] * along
    return float(np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1).max())


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-math.pi, math.pi))
def test_points_lie_on_the_walls_and_leave_no_hole(x: float, y: float, turn: float) -> None:
    pose = SE2(x, y, turn)
    points = heard((scan_of(ROOM, pose), pose, 0.0)).obstacle_points()
    assert off_walls(points, ROOM) < CORNER_CUT_M
    bearing = np.sort(np.arctan2(points[:, 1] - y, points[:, 0] - x))
    assert np.diff(bearing).max() < 0.12


def test_inside_is_free_outside_is_unknown() -> None:
    mapped = heard((scan_of(ROOM, CENTRE), CENTRE, 0.0))
    assert all(free(mapped, x, y) for x in (-1.8, 0.0, 1.8) for y in (-1.8, 0.0, 1.8))
    assert not any(free(mapped, x, y) for x, y in ((2.3, 0.0), (0.0, -2.3), (-3.0, 3.0)))


def test_a_gap_a_body_could_pass_is_not_bridged() -> None:
    # 0.5 m wide, seen at a distance at which the beams are 9 cm apart.
    walls: tuple[Wall, ...] = ((4, -3, 4, -0.25), (4, 0.25, 4, 3))
    pose = SE2()
    points = heard((scan_of(walls, pose, beams=270), pose, 0.0)).obstacle_points()
    assert not ((np.abs(points[:, 1]) < 0.15) & (points[:, 0] > 3.0)).any()


def test_a_wall_seen_at_a_grazing_angle_has_no_holes() -> None:
    wall: tuple[Wall, ...] = ((0, 1, 6, 1),)
    pose = SE2()
    points = heard((scan_of(wall, pose, beams=360), pose, 0.0)).obstacle_points()
    along = np.sort(points[points[:, 0] < 3.0, 0])
    assert np.diff(along).max() < 0.12


def test_what_has_gone_is_forgotten_at_the_next_look() -> None:
    person: tuple[Wall, ...] = ((1.0, -0.2, 1.0, 0.2),)
    mapped = heard((scan_of(ROOM + person, SE2()), SE2(), 0.0))
    assert not free(mapped, 1.0, 0.0)
    mapped.hear(scan_of(ROOM, SE2()), SE2(), 0.0)
    assert free(mapped, 1.0, 0.0)
    assert off_walls(mapped.obstacle_points(), ROOM) < CORNER_CUT_M


def test_what_was_not_seen_for_long_is_forgotten() -> None:
    config = ScanMapConfig(memory_m=3.0)
    blind = dataclasses.replace(scan_of(ROOM, CENTRE), ranges=np.full(360, np.nan))
    kept = heard((scan_of(ROOM, CENTRE), CENTRE, 0.0), (blind, CENTRE, 2.9), config=config)
    gone = heard((scan_of(ROOM, CENTRE), CENTRE, 0.0), (blind, CENTRE, 3.1), config=config)
    assert len(kept.obstacle_points()) > 0
    assert len(gone.obstacle_points()) == 0


def test_no_reading_is_neither_wall_nor_free() -> None:
    scan = scan_of(ROOM, SE2())
    ranges = scan.ranges.copy()
    ranges[170:190] = np.nan  # the middle of the scan looks ahead
    mapped = heard((dataclasses.replace(scan, ranges=ranges), SE2(), 0.0))
    points = mapped.obstacle_points()
    assert not free(mapped, 1.0, 0.0)
    assert not ((np.abs(points[:, 1]) < 0.25) & (points[:, 0] > 0.0)).any()


def test_silence_all_along_is_free_as_far_as_the_map_goes() -> None:
    nothing = dataclasses.replace(scan_of(ROOM, SE2()), ranges=np.full(360, np.inf))
    mapped = heard((nothing, SE2(), 0.0))
    assert free(mapped, 7.5, 0.0)
    assert not free(mapped, 8.5, 0.0)


def test_a_few_silent_beams_between_answers_do_not_open_a_wall() -> None:
    scan = scan_of(ROOM, SE2())
    ranges = scan.ranges.copy()
    ranges[175:185] = np.inf  # 10 degrees at 2 m: 0.35 m of a dark surface
    mapped = heard((dataclasses.replace(scan, ranges=ranges), SE2(), 0.0))
    assert not free(mapped, 3.0, 0.0)


def test_silence_over_the_end_of_the_scan_counts_as_one_run() -> None:
    scan = scan_of(ROOM, SE2())
    ranges = scan.ranges.copy()
    ranges[:5] = ranges[-5:] = np.inf  # behind, where the scan begins and ends
    mapped = heard((dataclasses.replace(scan, ranges=ranges), SE2(), 0.0))
    assert not free(mapped, -3.0, 0.0)


def test_too_near_is_an_obstacle() -> None:
    scan = scan_of(ROOM, SE2())
    ranges = scan.ranges.copy()
    ranges[180] = -np.inf
    mapped = heard((dataclasses.replace(scan, ranges=ranges), SE2(), 0.0))
    assert np.hypot(*mapped.obstacle_points().T).min() == pytest.approx(0.12, abs=1e-9)


@pytest.mark.parametrize("view", [math.pi, 1.5 * math.pi])
def test_what_lies_outside_the_field_of_view_is_unknown(view: float) -> None:
    mapped = heard((scan_of(ROOM, SE2(), view=view), SE2(), 0.0))
    assert free(mapped, 1.0, 0.0)
    assert not free(mapped, -1.0, 0.0)
    assert off_walls(mapped.obstacle_points(), ROOM) < CORNER_CUT_M


@given(st.floats(-math.pi, math.pi), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-3.0, 3.0))
def test_the_mounting_does_not_move_the_walls(turn: float, forward: float, left: float, yaw: float) -> None:
    pose, mounting = SE2(0.1, 0.1, turn), SE2(forward, left, yaw)
    points = heard((scan_of(CROSSING, pose, sensor_in_base=mounting), pose, 0.0)).obstacle_points()
    assert len(points) > 100
    assert off_walls(points, CROSSING) < CORNER_CUT_M


def test_a_touched_obstacle_outlasts_scans_that_do_not_see_it() -> None:
    config = ScanMapConfig(touch_memory_m=2.0)
    mapped = ScanMap(config)
    mapped.touch(0.5, 0.0, 0.0)
    mapped.hear(scan_of(T_JUNCTION, SE2()), SE2(), 1.9)
    assert not free(mapped, 0.5, 0.0)
    mapped.hear(scan_of(T_JUNCTION, SE2()), SE2(), 2.1)
    assert free(mapped, 0.5, 0.0)
