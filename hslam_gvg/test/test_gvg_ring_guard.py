"""The guard of the ring: the reflex minds what no wall explains."""

import numpy as np

from hslam_gvg.guards.ring_guard import RingGuard, RingGuardConfig
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SCOUT_RING, SonarPing, SonarSweep, Velocity

NOWHERE: Array = np.zeros((0, 2))
NEAR = SonarSweep(10, SCOUT_RING, (SonarPing(0, 10, 0.15), SonarPing(1, 10, 0.15)))


def commanded(unexplained: list[int]) -> Velocity:
    """Return what is left of a wish to drive on when both sonars ahead hear something."""
    guard = RingGuard(RingGuardConfig(), 0.19)
    guard.hear(NEAR, (SE2(), SE2()), SE2(), unexplained)
    return guard.limited(Velocity(0.05, 0.1), SE2(), NOWHERE)[0]


def test_echoes_that_no_wall_explains_stop() -> None:
    assert commanded([0, 1]).forward == 0.0


def test_echoes_of_known_walls_do_not() -> None:
    assert commanded([]).forward == 0.05


def minded(
    unexplained: list[int], ranges: tuple[float, float], bases: tuple[SE2, SE2] = (SE2(), SE2())
) -> tuple[Velocity, bool]:
    """Return what is left of a wish to drive on, and whether it had to be stopped, of two pings ahead."""
    guard = RingGuard(RingGuardConfig(), 0.19)
    pings = tuple(SonarPing(sensor, 10, range_m) for sensor, range_m in enumerate(ranges))
    guard.hear(SonarSweep(10, SCOUT_RING, pings), bases, SE2(), unexplained)
    return guard.limited(Velocity(0.05, 0.1), SE2(), NOWHERE)


def test_the_echo_that_is_minded_is_the_unexplained_one() -> None:
    assert minded([0], (0.05, 3.0)) == (Velocity(0.0, minded([0], (0.05, 3.0))[0].turn), True)
    assert minded([1], (0.05, 3.0))[0].forward == 0.05
    assert not minded([1], (0.05, 3.0))[1]


def test_and_it_is_placed_from_where_it_was_heard() -> None:
    far = SE2(-5.0, 0.0, 0.0)
    assert minded([1], (3.0, 0.05), (far, SE2()))[0].forward == 0.0
    assert minded([1], (3.0, 0.05), (SE2(), far))[0].forward == 0.05
