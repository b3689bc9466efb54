"""The map by sonars: walls where echoes agree, none where pings went past, free space where cones were silent."""

import math

import numpy as np
import pytest
from drawn_walls import Wall, points_of

from hslam_gvg.guards.ring_guard import RingGuardConfig
from hslam_gvg.local_graph.gaps import OPEN, SHUT, UNKNOWN
from hslam_gvg.ranging.cone_ping import PingPlaces, cone_pings
from hslam_gvg.ranging.sonar_map import SonarMap
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SCOUT_RING, OdometrySample, SonarPing, SonarSweep

CORRIDOR: tuple[Wall, ...] = ((-6, 1.0, 6, 1.0), (-6, -1.0, 6, -1.0))
DOOR: tuple[Wall, ...] = ((-6, 1.0, -0.5, 1.0), (0.5, 1.0, 6, 1.0), (-6, -1.0, 6, -1.0))
STEP_NS = 120_000_000
BODY_M = 0.19


def specular_range(walls: tuple[Wall, ...], base: SE2, sensor: int) -> float:
    """Return the distance (m) to the nearest piece, of walls along x, that is in the cone and met within 25 degrees."""
    axis, mount = base.theta + SCOUT_RING.bearings[sensor], SCOUT_RING.mount_radius_m
    off = points_of(walls, step_m=0.02) - (base.x + mount * math.cos(axis), base.y + mount * math.sin(axis))
    distance = np.hypot(off[:, 0], off[:, 1])
    in_cone = off @ (math.cos(axis), math.sin(axis)) > math.cos(SCOUT_RING.cone_half_angle) * distance
    answers = in_cone & (np.abs(off[:, 1]) > math.cos(math.radians(25.0)) * distance)
    return float(distance[answers].min(initial=math.inf))


class Listener:
    """A ring of sonars without noise carried among walls, and the map it draws."""

    def __init__(self, walls: tuple[Wall, ...], **settings: float) -> None:
        """Begin at rest with an empty map."""
        self.walls, self.stamp_ns, self.fired, self.travel_m = walls, 0, 0, 0.0
        self.map = SonarMap(SonarMapConfig.from_mapping(settings), RingGuardConfig(), BODY_M)
        self._last: SE2 | None = None

    def step(self, base: SE2, ranges: dict[int, float] | None = None) -> None:
        """Fire two sonars from a pose; ``ranges`` tells what some of them say instead of the truth."""
        self.stamp_ns += STEP_NS
        pings = []
        for _ in range(2):
            sensor = self.fired * 5 % 16
            self.fired += 1
            heard = (ranges or {}).get(sensor, specular_range(self.walls, base, sensor))
            pings.append(SonarPing(sensor, self.stamp_ns, heard if heard < SCOUT_RING.range_max_m else math.inf))
        if self._last is not None:
            self.travel_m += math.hypot(base.x - self._last.x, base.y - self._last.y)
        self._last = base
        sweep = SonarSweep(self.stamp_ns, SCOUT_RING, tuple(pings))
        self.map.hear(sweep, OdometrySample(self.stamp_ns, base), self.travel_m, attentive=False)

    def drive(self, x: float, to_x: float, ranges: dict[int, float] | None = None) -> None:
        """Drive along the x axis at 0.3 m/s."""
        for at in np.linspace(x, to_x, round(abs(to_x - x) / 0.036) + 1):
            self.step(SE2(float(at), 0.0, 0.0), ranges)


def off_walls_m(points: Array) -> Array:
    """Return how far each point lies from the walls of the corridor."""
    return np.abs(np.abs(points[:, 1]) - 1.0)


def test_a_driven_corridor_has_two_dense_walls_and_nothing_else() -> None:
    robot = Listener(CORRIDOR)
    robot.drive(-3.0, 1.0)
    points = robot.map.obstacle_points()
    assert off_walls_m(points).max() < 0.15
    for side in (-1.0, 1.0):
        wall = np.sort(points[points[:, 1] * side > 0.0, 0])
        along = wall[(wall > -2.5) & (wall < 0.5)]
        assert np.diff(along).max() < 0.4


def test_a_false_echo_that_other_pings_go_past_is_no_obstacle() -> None:
    robot = Listener(CORRIDOR)
    robot.drive(-3.0, -1.0)
    robot.step(SE2(-1.0, 0.0, 0.0), dict.fromkeys(range(16), 0.5))
    robot.drive(-1.0, 1.0)
    points = robot.map.obstacle_points()
    assert off_walls_m(points).max() < 0.2


def test_walls_are_not_erased_by_pings_along_them() -> None:
    # Those forwards and backwards go far past every piece of wall, but a wall met askew does not answer.
    robot = Listener(CORRIDOR)
    robot.drive(-3.0, 0.0)
    before = robot.map.obstacle_points()
    robot.drive(0.0, 2.0, {0: math.inf, 1: math.inf, 7: math.inf, 8: math.inf, 9: math.inf, 15: math.inf})
    after = robot.map.obstacle_points()
    near = [np.count_nonzero((p[:, 0] > -2.0) & (p[:, 0] < -0.5)) for p in (before, after)]
    assert near[1] > 0.8 * near[0]


def test_space_is_free_in_a_cone_up_to_its_echo() -> None:
    robot = Listener(((50, 50, 60, 50),))
    robot.step(SE2(), {0: 1.0, 5: math.inf})
    x, y = np.array([0.9, 0.9, 1.2, 0.9]), np.array([0.0, 0.1, 0.0, 0.3])
    assert robot.map.is_free(x, y).tolist() == [True, True, False, False]
    axis = SCOUT_RING.bearings[5]
    silent = np.array([3.0, 3.4])
    assert robot.map.is_free(silent * math.cos(axis), silent * math.sin(axis)).tolist() == [True, False]


def test_a_gap_is_open_where_pings_went_through_and_shut_where_they_ended() -> None:
    robot = Listener(DOOR)
    robot.drive(-3.0, 2.5)
    begin = np.array([[-0.5, 1.0], [-0.5, -1.0], [5.0, 1.0]])
    end = np.array([[0.5, 1.0], [0.5, -1.0], [5.8, 1.0]])
    assert robot.map.gaps(begin, end).tolist() == [OPEN, SHUT, UNKNOWN]


def test_a_piece_of_wall_that_was_missed_twice_is_no_gap() -> None:
    robot = Listener(CORRIDOR)
    robot.drive(-3.0, -0.5)
    robot.drive(-0.46, 0.1, {4: math.inf})
    robot.drive(0.13, 2.5)
    gap = np.array([[-0.5, 1.0]]), np.array([[0.3, 1.0]])
    through, ended = robot.map._pings.met(*gap, robot.travel_m)
    assert through[0] >= 2
    assert ended[0] > through[0]
    assert robot.map.gaps(*gap).tolist() == [SHUT]


def test_a_wide_gap_needs_no_proof() -> None:
    robot = Listener(DOOR, doubtful_m=0.9)
    assert robot.map.gaps(np.array([[5.0, 0.0]]), np.array([[5.0, 1.0]])).tolist() == [OPEN]


def test_where_the_body_has_been_nothing_is() -> None:
    robot = Listener(CORRIDOR)
    robot.drive(-2.0, 0.0)
    ahead = {0: 0.3}
    for _ in range(24):  # something is heard ahead from several places, and is not there
        robot.drive(0.0, 0.12, ahead)
    robot.drive(0.12, 1.5)
    points = robot.map.obstacle_points()
    assert np.hypot(points[:, 0] - 0.5, points[:, 1]).min() >= BODY_M


def test_what_was_touched_stays_for_some_travel() -> None:
    robot = Listener(CORRIDOR)
    robot.drive(-2.0, 0.0)
    robot.map.touch(0.5, 0.0, robot.travel_m)
    assert [0.5, 0.0] in robot.map.obstacle_points().tolist()
    robot.drive(0.0, -4.5)
    assert [0.5, 0.0] not in robot.map.obstacle_points().tolist()


def test_what_was_not_heard_again_is_forgotten() -> None:
    robot = Listener(CORRIDOR, memory_m=2.0)
    robot.drive(-5.9, 0.0)
    assert robot.map.obstacle_points()[:, 0].min() > -2.8
    assert not robot.map.is_free(np.array([-5.5]), np.array([0.0]))[0]


def test_pings_are_placed_where_they_were_fired_with_their_own_mounting() -> None:
    places = PingPlaces()
    places.of(SonarSweep(0, SCOUT_RING, ()), OdometrySample(0, SE2(0.0, 0.0, math.pi - 0.1)))
    sweep = SonarSweep(100, SCOUT_RING, (SonarPing(4, 50, 1.0), SonarPing(0, 100, 9.0)))
    half_way, last = cone_pings(sweep, places.of(sweep, OdometrySample(100, SE2(1.0, 0.0, 0.1 - math.pi))))
    assert (half_way.x, half_way.y) == pytest.approx((0.5, -0.19))
    assert abs(math.remainder(half_way.axis + 0.5 * math.pi, math.tau)) < 1e-9
    assert last.range_m == math.inf
    assert last.half_cone == SCOUT_RING.cone_half_angle
