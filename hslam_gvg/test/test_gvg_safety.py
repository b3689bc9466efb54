"""The reflex: one near echo slows, two stop, turning is always free."""

import math

import pytest

from hslam_gvg.config import GvgConfig
from hslam_gvg.safety import CRAWL_M_S, Reflex
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, SonarPing, SonarSweep, Velocity

HERE = SE2(1.0, 2.0, 0.5)


def reflex_hearing(*pings: tuple[int, float]) -> Reflex:
    reflex = Reflex(GvgConfig())
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
