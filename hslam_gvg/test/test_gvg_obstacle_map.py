"""The local map: where it puts walls, what it forgets and what it does not believe."""

import math

import numpy as np
from drawn_walls import DEAD_END, HALF, T_JUNCTION, Wall, ideal_range

from hslam_gvg.arc import Arc
from hslam_gvg.config import GvgConfig
from hslam_gvg.obstacle_map import ObstacleMap
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, SonarPing, SonarSweep

CONE = SCOUT_RING.cone_half_angle


def drive(walls: tuple[Wall, ...], start: float, end: float, noise: float = 0.01) -> ObstacleMap:
    """Drive along y = 0, two pings every five centimetres."""
    memory, rng = ObstacleMap(GvgConfig()), np.random.default_rng(1)
    number = 0
    for x in np.arange(start, end, 0.05):
        base = SE2(float(x), 0.0, 0.0)
        memory.move(base)
        pings = []
        for _ in range(2):
            sensor = (number * 5) % 16
            number += 1
            heard = ideal_range(walls, base, sensor) * (1.0 + noise * float(rng.standard_normal()))
            pings.append(SonarPing(sensor, 0, heard if heard < SCOUT_RING.range_max_m else math.inf))
        memory.hear(SonarSweep(0, SCOUT_RING, tuple(pings)), (base, base))
    return memory


def test_walls_beside_a_drive_are_dense_and_exact() -> None:
    points = drive(T_JUNCTION, -7.0, -3.0).points()
    near = points[(points[:, 0] > -6.0) & (points[:, 0] < -4.0)]
    off = np.abs(np.abs(near[:, 1]) - HALF)
    assert np.median(off) < 0.02
    assert np.percentile(off, 90) < 0.1
    for side in (near[:, 1] > 0.0, near[:, 1] < 0.0):
        assert np.diff(np.sort(near[side][:, 0])).max() < 0.4


def test_an_opening_stays_open() -> None:
    points = drive(T_JUNCTION, -4.0, 4.0).points()
    inside = points[(np.abs(points[:, 0]) < 0.5 * HALF) & (points[:, 1] < -0.9)]
    assert not len(inside[np.abs(inside[:, 1]) < 2.0])


def test_the_end_of_a_corridor_is_seen() -> None:
    points = drive(DEAD_END, -4.0, 0.1).points()
    end = points[np.abs(points[:, 1]) < 0.3]
    assert len(end) >= 2
    assert abs(np.median(end[:, 0]) - HALF) < 0.05


def test_points_are_forgotten_by_travel_not_by_time() -> None:
    memory = drive(T_JUNCTION, -7.0, -3.0)
    for _ in range(1000):
        memory.move(SE2(-3.05, 0.0, 0.0))
    assert len(memory.points()) > 50
    memory.move(SE2(20.0, 0.0, 0.0))
    memory.add(Arc(20.0, 0.0, 0.0, 1.0), CONE)
    assert len(memory.points()) == 0


def test_a_lone_echo_is_not_believed() -> None:
    memory = ObstacleMap(GvgConfig())
    memory.move(SE2())
    memory.add(Arc(0.19, 0.0, 0.0, 0.7), CONE)
    assert len(memory.points()) == 0


def test_standing_still_adds_no_points() -> None:
    memory = ObstacleMap(GvgConfig())
    memory.move(SE2())
    counts = []
    for _ in range(40):
        memory.add(Arc(0.19, 0.0, 0.0, 0.7), CONE)
        counts.append(len(memory.points()))
    assert counts[-1] == counts[5] == 1


def test_the_body_clears_what_it_stands_in() -> None:
    memory = ObstacleMap(GvgConfig())
    memory.move(SE2())
    for _ in range(5):
        memory.add(Arc(0.19, 0.0, 0.0, 0.7), CONE)
    assert len(memory.points()) == 1
    memory.move(SE2(0.85, 0.0, 0.0))
    assert len(memory.points()) == 0
