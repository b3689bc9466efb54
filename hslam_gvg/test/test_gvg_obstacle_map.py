"""The local map: where it puts walls, what it forgets and what it does not believe."""

import math

import numpy as np
import pytest
from drawn_walls import DEAD_END, HALF, T_JUNCTION, Wall, ideal_range

from hslam_gvg.arc import Arc
from hslam_gvg.config import GvgConfig
from hslam_gvg.obstacle_map import CAPACITY, SAME_AXIS, SAME_PLACE_M, TOUCH_SLACK_M, TOUCHED, UNRESOLVED_M, ObstacleMap
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


LONELY = Arc(0.19, 0.0, 0.0, 0.7)


def test_an_echo_that_is_heard_again_is_remembered_from_then_on() -> None:
    """The robot turns on the spot, which counts as travel: what it still hears it does not forget."""
    config = GvgConfig()
    known: dict[bool, int] = {}
    for repeated in (True, False):
        memory = ObstacleMap(config)
        memory.move(SE2())
        memory.add(LONELY, CONE)
        memory.add(LONELY, CONE)
        turns = round(0.7 * config.memory_m / (3.0 * config.metres_per_radian))
        for half in (0, 1):
            for i in range(turns):
                memory.move(SE2(0.0, 0.0, 3.0 * (i % 2)))
            if repeated and half == 0:
                memory.add(LONELY, CONE)
        assert config.memory_m < memory.travel_m < 2.0 * 0.7 * config.memory_m
        known[repeated] = len(memory.suspects())
    assert known == {True: 1, False: 0}


@pytest.mark.parametrize(
    "other",
    [
        pytest.param(LONELY._replace(x=LONELY.x + 1.1 * SAME_PLACE_M), id="from elsewhere"),
        pytest.param(LONELY._replace(axis=1.1 * SAME_AXIS), id="by another sonar"),
        pytest.param(LONELY._replace(range_m=LONELY.range_m + 1.1 * SAME_PLACE_M), id="of another range"),
    ],
)
def test_another_echo_is_no_repetition(other: Arc) -> None:
    memory = ObstacleMap(GvgConfig())
    memory.move(SE2())
    for arc in (LONELY, other):
        memory.add(arc, CONE)
    assert memory._count == 2


def test_an_echo_that_nothing_places_is_believed_from_near_alone() -> None:
    """Heard twice it is kept clear of from twice as far; a cluster of three is believed from there too."""
    for range_m, believed in ((UNRESOLVED_M - 0.01, 1), (UNRESOLVED_M + 0.01, 0)):
        memory = ObstacleMap(GvgConfig())
        memory.move(SE2())
        counts = []
        for _ in range(4):
            memory.add(LONELY._replace(range_m=range_m), CONE)
            counts.append((len(memory.points()), len(memory.suspects())))
        assert counts == [(0, 0), (0, 1), (believed, 1), (1, 1)]


def test_what_lies_beyond_the_reach_is_kept_only_if_other_arcs_place_it() -> None:
    config = GvgConfig()
    memory = ObstacleMap(config)
    memory.move(SE2())
    memory.add(LONELY._replace(range_m=config.reach_m + 1.01), CONE)
    assert memory._count == 0
    memory.add(LONELY._replace(range_m=config.reach_m + 0.99), CONE)
    assert memory._count == 1


def test_only_ranges_that_the_ring_can_measure_are_echoes() -> None:
    memory = ObstacleMap(GvgConfig())
    memory.move(SE2())
    for range_m in (SCOUT_RING.range_min_m - 0.01, SCOUT_RING.range_max_m, math.inf, -math.inf, math.nan):
        memory.hear(SonarSweep(0, SCOUT_RING, (SonarPing(0, 0, range_m),)), (SE2(),))
    assert memory._count == 0
    memory.hear(SonarSweep(0, SCOUT_RING, (SonarPing(0, 0, SCOUT_RING.range_min_m),)), (SE2(),))
    assert memory._count == 1


def test_a_touch_is_believed_at_once_and_forgotten_like_an_echo() -> None:
    config = GvgConfig()
    memory = ObstacleMap(config)
    memory.move(SE2())
    memory.touch(SE2(), 1.0)
    touched = memory.points()
    assert len(touched) == len(TOUCHED)
    assert np.hypot(*touched.T) == pytest.approx(config.body_m + TOUCH_SLACK_M)
    assert (touched[:, 0] > 0.0).all()
    memory.move(SE2(-config.memory_m - 0.01, 0.0, 0.0))
    assert len(memory.points()) == 0


def test_a_full_memory_forgets_its_oldest_quarter() -> None:
    memory = ObstacleMap(GvgConfig())
    memory.move(SE2())
    for i in range(CAPACITY):
        memory.add(Arc(0.01 * i, 10.0 * (i % 7), 0.0, 0.3), CONE)
    assert memory._count == CAPACITY
    memory.touch(SE2(), 1.0)
    assert memory._count == CAPACITY - CAPACITY // 4 + len(TOUCHED)
    assert memory._x[0] == pytest.approx(0.01 * (CAPACITY // 4))
