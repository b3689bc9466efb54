"""The reflex: one near echo slows, two stop, turning is always free."""

import math
from dataclasses import replace

import pytest

from hslam_gvg.config import GvgConfig
from hslam_gvg.safety import APPROACH_RATE, CRAWL_M_S, CREPT_NS, HEARD_NS, SIDE_ROOM_M, Reflex
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, SonarPing, SonarSweep, Velocity

HERE = SE2(1.0, 2.0, 0.5)
CONFIG = GvgConfig()


def reflex_hearing(*pings: tuple[int, float]) -> Reflex:
    reflex = Reflex(CONFIG)
    sweep = SonarSweep(10, SCOUT_RING, tuple(SonarPing(sensor, 10, heard) for sensor, heard in pings))
    reflex.hear(sweep, (HERE,) * len(pings))
    return reflex


def test_nothing_heard_changes_nothing() -> None:
    assert reflex_hearing((0, math.inf)).limit(Velocity(0.4, 0.3), HERE) == Velocity(0.4, 0.3)


def test_one_near_echo_slows() -> None:
    command = reflex_hearing((0, 0.18)).limit(Velocity(0.4, 0.3), HERE)
    assert command == Velocity(CRAWL_M_S, 0.3)


def test_two_near_echoes_stop_the_way_there_but_not_back() -> None:
    reflex = reflex_hearing((0, 0.18), (1, 0.19), (0, 0.18))
    assert reflex.limit(Velocity(0.4, 0.3), HERE) == Velocity(0.0, 0.3)
    assert reflex.blocked
    assert reflex.limit(Velocity(-0.4, 0.3), HERE) == Velocity(-0.4, 0.3)
    assert not reflex.blocked


def test_what_stands_beside_does_not_slow() -> None:
    assert reflex_hearing((4, 0.2), (12, 0.2)).limit(Velocity(0.4), HERE) == Velocity(0.4)


def test_speed_falls_with_the_room() -> None:
    speeds = [reflex_hearing((0, room)).limit(Velocity(0.4), HERE).forward for room in (0.7, 0.5, 0.3)]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] == pytest.approx(0.4)
    assert speeds[-1] < 0.1


def test_room_is_reckoned_from_the_body_wherever_the_ring_is_mounted() -> None:
    reflex = Reflex(GvgConfig(body_m=0.3))
    reflex.hear(SonarSweep(10, SCOUT_RING, (SonarPing(0, 10, 0.5),)), (HERE,))
    assert reflex.room(HERE, backwards=False)[0] == pytest.approx(SCOUT_RING.mount_radius_m + 0.5 - 0.3)


def test_old_echoes_are_forgotten() -> None:
    reflex = reflex_hearing((0, 0.18), (0, 0.18))
    reflex.hear(SonarSweep(3_000_000_000, SCOUT_RING, ()), ())
    assert reflex.limit(Velocity(0.4), HERE) == Velocity(0.4)


def test_an_edge_that_falls_silent_is_minded_while_the_robot_hardly_moves() -> None:
    def limited(moved_m: float) -> Velocity:
        reflex = reflex_hearing((0, 0.5), (0, 0.5))
        there = SE2(*HERE.apply(moved_m, 0.0), HERE.theta)
        for stamp_ns in (1_900_000_000, 2_000_000_000):
            reflex.hear(SonarSweep(stamp_ns, SCOUT_RING, (SonarPing(8, stamp_ns, math.inf),)), (there,))
        return reflex.limit(Velocity(0.4), there)

    assert limited(0.2).forward < 0.2
    assert limited(0.4) == Velocity(0.4)


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_only_echoes_in_the_strip_that_the_body_sweeps_are_in_its_way(backwards: bool, side: float) -> None:
    """A strip the body and a little wide, ahead of its centre alone."""
    half_m, turned = CONFIG.body_m + SIDE_ROOM_M, math.pi if backwards else 0.0
    for ahead_m, left_m, met in (
        (0.5, half_m - 0.01, True),
        (0.5, half_m + 0.01, False),
        (-0.5, 0.0, False),
    ):
        distance_m, azimuth = math.hypot(ahead_m, left_m), math.atan2(side * left_m, ahead_m) + turned
        # The ring is turned so that one sonar looks there.
        ring = replace(SCOUT_RING, bearings=(azimuth,))
        reflex = Reflex(CONFIG)
        ping = SonarPing(0, 10, distance_m - SCOUT_RING.mount_radius_m)
        reflex.hear(SonarSweep(10, ring, (ping,)), (HERE,))
        expected = distance_m - CONFIG.body_m if met else math.inf
        assert reflex.room(HERE, backwards) == pytest.approx((expected, math.inf))


def test_rooms_are_the_nearest_and_the_second_nearest() -> None:
    assert reflex_hearing((0, 0.5), (0, 0.3), (0, 0.7)).room(HERE, backwards=False) == pytest.approx((0.3, 0.5))


def test_an_echo_stays_where_it_was_heard_while_the_body_drives_on() -> None:
    reflex, there = reflex_hearing((0, 0.5)), SE2(*HERE.apply(0.2, 0.0), HERE.theta)
    assert reflex.room(there, backwards=False)[0] == pytest.approx(0.3)


@pytest.mark.parametrize("forward", [0.4, -0.4])
def test_speed_is_bound_by_the_room_to_where_the_body_would_stop(forward: float) -> None:
    sensor = 0 if forward > 0.0 else 8
    for room_m in (0.5, 0.4, 0.35):
        command = reflex_hearing((sensor, room_m)).limit(Velocity(forward), HERE)
        expected = max(CRAWL_M_S, APPROACH_RATE * (room_m - CONFIG.stop_m))
        assert command.forward == pytest.approx(math.copysign(expected, forward))


@pytest.mark.parametrize(
    ("rooms", "blocked"),
    [
        ((CONFIG.stop_m - 0.01,), False),
        ((CONFIG.stop_m - 0.01, CONFIG.second_echo_m + 0.01), False),
        ((CONFIG.stop_m - 0.01, CONFIG.second_echo_m - 0.01), True),
        ((CONFIG.stop_m + 0.01, CONFIG.stop_m + 0.02), False),
        ((0.5 * CONFIG.stop_m + 0.01,), False),
        ((0.5 * CONFIG.stop_m - 0.01,), True),
    ],
)
def test_it_stops_for_two_echoes_or_for_a_very_near_one(rooms: tuple[float, ...], blocked: bool) -> None:
    reflex = reflex_hearing(*((0, room_m) for room_m in rooms))
    command = reflex.limit(Velocity(0.4), HERE)
    assert reflex.blocked is blocked
    assert (command.forward == 0.0) is blocked


def test_turning_on_the_spot_is_free_whatever_is_heard() -> None:
    reflex = reflex_hearing((0, 0.02), (0, 0.02))
    assert reflex.limit(Velocity(0.0, 1.0), HERE) == Velocity(0.0, 1.0)
    assert not reflex.blocked


def test_an_echo_is_minded_for_a_full_sweep_however_far_the_robot_goes() -> None:
    for age_ns, minded in ((HEARD_NS, True), (HEARD_NS + 1, False)):
        reflex = reflex_hearing((0, 1.0))
        far = SE2(*HERE.apply(0.5, 0.0), HERE.theta)
        reflex.hear(SonarSweep(10, SCOUT_RING, (SonarPing(8, 10, math.inf),)), (far,))
        reflex.hear(SonarSweep(10 + age_ns, SCOUT_RING, ()), ())
        assert (reflex.room(far, backwards=False)[0] < math.inf) is minded


def test_an_echo_is_forgotten_in_the_end_even_where_the_robot_stands() -> None:
    for age_ns, minded in ((CREPT_NS, True), (CREPT_NS + 1, False)):
        reflex = reflex_hearing((0, 0.5))
        reflex.hear(SonarSweep(10 + age_ns, SCOUT_RING, ()), ())
        assert (reflex.room(HERE, backwards=False)[0] < math.inf) is minded
