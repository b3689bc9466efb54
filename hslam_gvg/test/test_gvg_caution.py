"""Caution: which pings have listened where, and the pace and the stops that follow from that."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hslam_gvg.caution import (
    AHEAD,
    APPROACH_RATE,
    BESIDE_WALLS,
    BODY_NEXT_M,
    EDGE_M,
    FROM_WALLS,
    NEXT_M,
    ONE,
    PING_RATE,
    PINGS,
    SEVERAL,
    STRIP_HALF_M,
    STRIP_M,
    TIGHT_M,
    TOGETHER_M,
    Caution,
)
from hslam_gvg.config import GvgConfig
from hslam_gvg.trail import Trail
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SCOUT_RING, SonarPing, SonarRing, SonarSweep, Velocity

CONFIG = GvgConfig()
MOUNT_M = SCOUT_RING.mount_radius_m
HERE = SE2(1.0, -2.0, 0.7)
NOTHING = np.zeros((0, 2))
FRONT, LEFT, REAR = 0, 4, 8
WISH = Velocity(0.4, 0.2)


def hear(
    caution: Caution, sensor: int, range_m: float = math.inf, pings: int = 1, ring: SonarRing = SCOUT_RING
) -> None:
    """Let one sonar of the ring at HERE fire."""
    caution.hear(SonarSweep(0, ring, (SonarPing(sensor, 0, range_m),) * pings), (HERE,) * pings)


def place(distance_m: float, off_axis: float, sensor: int = FRONT) -> tuple[float, float]:
    """Return a place (m, odom) seen from a sonar's face at HERE."""
    axis = SCOUT_RING.bearings[sensor]
    return HERE.apply(
        MOUNT_M * math.cos(axis) + distance_m * math.cos(axis + off_axis),
        MOUNT_M * math.sin(axis) + distance_m * math.sin(axis + off_axis),
    )


def seen_from_here(*points: tuple[float, float]) -> Array:
    """Return points given in base_link at HERE, in odom."""
    return HERE.apply_all(np.array(points))


def limited(caution: Caution, wish: Velocity, points: Array, witnesses: int = SEVERAL) -> Velocity:
    return caution.limit(wish, HERE, points, Trail(), witnesses)


@pytest.mark.parametrize("sensor", [FRONT, LEFT, 11])
@pytest.mark.parametrize(("degrees", "heard"), [(0.0, 1), (14.0, 1), (-14.0, 1), (16.0, 0), (-16.0, 0), (180.0, 0)])
def test_a_sonar_listens_within_its_cone(sensor: int, degrees: float, heard: int) -> None:
    caution = Caution(CONFIG)
    hear(caution, sensor)
    assert caution.listened(*place(0.5, math.radians(degrees), sensor)) == heard


def test_a_sonar_listens_as_far_as_it_heard_nothing_and_an_edge_answers() -> None:
    caution = Caution(CONFIG)
    hear(caution, FRONT)
    assert [caution.listened(*place(d, 0.0)) for d in (EDGE_M - 0.01, EDGE_M + 0.01)] == [1, 0]
    hear(caution, LEFT, 0.8)
    assert [caution.listened(*place(d, 0.0, LEFT)) for d in (0.79, 0.81)] == [1, 0]


def test_an_older_ping_is_judged_by_the_cone_of_its_own_ring() -> None:
    caution = Caution(CONFIG)
    narrow, wide = replace(SCOUT_RING, cone_half_angle=0.05), replace(SCOUT_RING, cone_half_angle=0.5)
    hear(caution, FRONT, ring=narrow)
    hear(caution, LEFT, ring=wide)
    assert caution.listened(*place(0.5, 0.1)) == 0
    hear(caution, REAR, ring=narrow)
    assert caution.listened(*place(0.5, 0.4, LEFT)) == 1


def test_pings_are_forgotten_in_the_order_they_came() -> None:
    caution = Caution(CONFIG)
    hear(caution, FRONT, pings=3)
    hear(caution, REAR, pings=PINGS - 1)
    assert caution.listened(*place(0.5, 0.0)) == 1
    hear(caution, REAR)
    assert caution.listened(*place(0.5, 0.0)) == 0


def test_before_the_first_ping_nothing_has_been_listened_to() -> None:
    assert Caution(CONFIG).listened(0.0, 0.0) == 0


@pytest.mark.parametrize(("wish", "sensor"), [(WISH, FRONT), (Velocity(-0.4, 0.2), REAR)])
def test_the_pace_is_that_of_the_pings_still_missing_where_the_way_leads(wish: Velocity, sensor: int) -> None:
    caution, other = Caution(CONFIG), {FRONT: REAR, REAR: FRONT}[sensor]
    beside = seen_from_here((0.0, 1.0), (0.0, -1.0))
    for pings in range(int(BESIDE_WALLS)):
        command = limited(caution, wish, beside)
        expected = min(0.4, max(CONFIG.creep_m_s, PING_RATE * 1.0 / (BESIDE_WALLS - pings)))
        assert command == pytest.approx((math.copysign(expected, wish.forward), wish.turn))
        hear(caution, sensor)
        hear(caution, other)
    assert limited(caution, wish, beside) == wish


def test_it_is_asked_what_was_listened_to_just_ahead_of_the_body() -> None:
    """A ping that ends short of there has not listened there."""
    beside = seen_from_here((0.0, 1.0), (0.0, -1.0))
    speeds = []
    for range_m in (NEXT_M - MOUNT_M - 0.01, NEXT_M - MOUNT_M + 0.01):
        caution = Caution(CONFIG)
        hear(caution, FRONT, range_m, pings=20)
        speeds.append(limited(caution, WISH, beside).forward)
    assert speeds == [pytest.approx(PING_RATE / BESIDE_WALLS), WISH.forward]


def test_with_nothing_known_the_free_disc_is_the_reach() -> None:
    assert limited(Caution(CONFIG), WISH, NOTHING).forward == pytest.approx(PING_RATE * CONFIG.reach_m / FROM_WALLS)


@pytest.mark.parametrize(
    ("points", "pings"),
    [
        pytest.param([(0.0, 1.0), (0.0, -1.0)], BESIDE_WALLS, id="abreast"),
        pytest.param([(-1.0, 1.0), (-1.0, -1.0)], FROM_WALLS, id="left behind"),
        pytest.param([(-1.0, 1.0), (0.0, -1.0)], BESIDE_WALLS, id="one side abreast"),
        pytest.param([(-0.2, 0.98), (-0.2, -0.98)], BESIDE_WALLS + 0.5 * (FROM_WALLS - BESIDE_WALLS), id="between"),
        pytest.param([(-1.0, 1.0), (STRIP_M - 0.01, STRIP_HALF_M - 0.01)], BESIDE_WALLS, id="something ahead"),
        pytest.param([(-1.0, 1.0), (STRIP_M + 0.01, STRIP_HALF_M - 0.01)], FROM_WALLS, id="too far ahead"),
    ],
)
def test_how_much_listening_it_takes_depends_on_what_is_known_beside(
    points: list[tuple[float, float]], pings: float
) -> None:
    caution, known = Caution(CONFIG), seen_from_here(*points)
    free_m = min(math.hypot(*point) for point in points)
    assert limited(caution, WISH, known).forward == pytest.approx(PING_RATE * free_m / pings, rel=0.02)


def test_known_obstacles_slow_by_the_room_that_is_left() -> None:
    caution = Caution(CONFIG)
    hear(caution, FRONT, pings=40)
    for room_m in (0.4, 0.2, 0.1):
        known = seen_from_here((CONFIG.body_m + TIGHT_M + room_m, 0.0))
        assert limited(caution, WISH, known).forward == pytest.approx(max(CONFIG.creep_m_s, APPROACH_RATE * room_m))


@pytest.mark.parametrize(("wish", "turned"), [(Velocity(0.1, 0.3), 0.0), (Velocity(-0.1, 0.3), math.pi)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_only_what_lies_in_a_cone_of_the_way_stops(wish: Velocity, turned: float, side: float) -> None:
    cone = math.acos(AHEAD)
    for off, blocked in ((cone - 0.02, True), (cone + 0.02, False), (math.pi, False)):
        azimuth, reach_m = turned + side * off, CONFIG.body_m + TIGHT_M - 0.01
        caution = Caution(CONFIG)
        command = limited(
            caution, wish, seen_from_here((reach_m * math.cos(azimuth), reach_m * math.sin(azimuth))), ONE
        )
        assert caution.blocked is blocked
        assert (command.forward == 0.0) is blocked
        assert command.turn == wish.turn


def test_what_leaves_the_body_a_little_room_does_not_stop_it() -> None:
    caution, wish = Caution(CONFIG), Velocity(0.05, 0.0)
    assert limited(caution, wish, seen_from_here((CONFIG.body_m + TIGHT_M + 0.01, 0.0)), ONE) == wish
    assert not caution.blocked


def test_witnesses_are_of_one_obstacle() -> None:
    nearest = CONFIG.body_m + TIGHT_M - 0.01
    apart, together = CONFIG.body_m + TIGHT_M + TOGETHER_M + 0.01, CONFIG.body_m + TIGHT_M + TOGETHER_M - 0.01
    for third, blocked in ((apart, False), (together, True)):
        caution = Caution(CONFIG)
        limited(caution, WISH, seen_from_here((nearest, 0.0), (nearest, 0.01), (third, 0.0)))
        assert caution.blocked is blocked


def test_witnesses_beside_the_way_are_none() -> None:
    nearest = CONFIG.body_m + TIGHT_M - 0.01
    caution = Caution(CONFIG)
    limited(caution, WISH, seen_from_here((nearest, 0.0), (0.0, nearest), (-nearest, 0.0)))
    assert not caution.blocked


def test_standing_and_turning_are_never_limited() -> None:
    caution = Caution(CONFIG)
    assert limited(caution, Velocity(0.0, 1.0), seen_from_here((0.2, 0.0)), ONE) == Velocity(0.0, 1.0)
    assert not caution.blocked


@pytest.mark.parametrize(("been_m", "slowed"), [(BODY_NEXT_M, False), (-BODY_NEXT_M, True)])
def test_only_a_trail_where_the_body_goes_next_frees_it(been_m: float, slowed: bool) -> None:
    caution, trail = Caution(CONFIG), Trail()
    trail.advance(*HERE.apply(been_m, 0.0))
    command = caution.limit(WISH, HERE, seen_from_here((0.0, 1.0), (0.0, -1.0)), trail, SEVERAL)
    assert (command.forward < WISH.forward) is slowed
