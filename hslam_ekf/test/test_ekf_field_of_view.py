"""Absences outside the field of view: a sensor of one half does not forget what is in the other."""

import math

import pytest

from hslam_ekf.config import EkfConfig
from hslam_ekf.traversal import Traversal
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import FieldOfView, LandmarkSighting, LandmarkView

HALF = FieldOfView(bearing_from=-math.pi / 2.0, bearing_to=math.pi / 2.0)
AHEAD, BEHIND = (2.0, 0.4), (-2.0, 0.3)


def sighting(base: SE2, landmark: tuple[float, float]) -> LandmarkSighting:
    """Return a landmark as seen from a pose, without error."""
    x, y = base.inverse().apply(*landmark)
    return LandmarkSighting(math.hypot(x, y), math.atan2(y, x), 0.05, 0.02)


def look(base: SE2, field: FieldOfView, *, half: bool = True) -> LandmarkView:
    """Return the look of a sensor that sees what lies before it, whatever field it claims."""
    seen = [sighting(base, landmark) for landmark in (AHEAD, BEHIND)]
    told = [s for s in seen if not half or abs(wrap(s.bearing)) < math.pi / 2.0]
    return LandmarkView(0, 5.0, tuple(told), field)


def landmarks_after_turning(field: FieldOfView, first_looks: int) -> int:
    """Return how many landmarks are left of one seen so often, then behind for fifteen looks, then seen again."""
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    for heading, looks in ((0.0, first_looks), (math.pi, 15), (0.0, 1)):
        base = SE2(0.0, 0.0, heading)
        traversal.advance(base)
        for _ in range(looks):
            traversal.look(look(base, field))
    return sum(math.dist(place, AHEAD) < 0.3 for place in traversal.filter.landmarks.tolist())


@pytest.mark.parametrize("first_looks", [2, 4])
def test_what_is_outside_the_field_is_not_missed(first_looks: int) -> None:
    assert landmarks_after_turning(HALF, first_looks) == 1


def test_all_round_the_same_absences_count() -> None:
    """Seen twice it is forgotten behind the back and begins anew; seen four times it is dropped when seen again."""
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    traversal.look(look(SE2(), FieldOfView()))
    traversal.look(look(SE2(), FieldOfView()))
    assert len(traversal.filter.landmarks) == 1
    turned = SE2(0.0, 0.0, math.pi)
    traversal.advance(turned)
    for _ in range(10):
        traversal.look(look(turned, FieldOfView()))
    assert [math.dist(place, AHEAD) < 0.3 for place in traversal.filter.landmarks.tolist()] == [False]
    assert landmarks_after_turning(FieldOfView(), 4) == 0


def test_a_landmark_near_the_edge_is_not_missed_by_an_edge_it_may_lie_beyond() -> None:
    """It is expected a degree inside, and known to three: whether it ought to be seen nobody knows."""
    field = HALF._replace(bearing_to=math.atan2(AHEAD[1], AHEAD[0]) + math.radians(1.0))
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    base = SE2(0.5, 0.0, 0.0)
    for _ in range(2):
        traversal.look(LandmarkView(0, 5.0, (sighting(SE2(), AHEAD)._replace(bearing_std=0.1),), field))
    traversal.advance(base)
    edge = field._replace(bearing_to=sighting(base, AHEAD).bearing + math.radians(1.0))
    for _ in range(10):
        traversal.look(LandmarkView(0, 5.0, (), edge))
    assert len(traversal.filter.landmarks) == 1
    for _ in range(3):
        traversal.look(LandmarkView(0, 5.0, (), edge._replace(bearing_to=math.pi / 2.0)))
    assert not len(traversal.filter.landmarks)


def test_the_margin_is_the_bearing_s_however_well_the_range_is_known() -> None:
    """Expected three degrees inside, known to five in bearing and to a millimetre in range."""
    edge = HALF._replace(bearing_to=math.radians(3.0))
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    ahead = LandmarkSighting(2.0, 0.0, 0.001, math.radians(7.0))
    for _ in range(2):
        traversal.look(LandmarkView(0, 5.0, (ahead,), edge))
    for _ in range(10):
        traversal.look(LandmarkView(0, 5.0, (), edge))
    assert len(traversal.filter.landmarks) == 1


def test_a_sensor_before_the_base_sees_as_far_as_it_sees_from_there() -> None:
    """A landmark 2.8 m from the base is 1.8 m from a sensor of 2 m: the one that was seen, not a new one each time."""
    field = FieldOfView(sensor_x=1.0)
    traversal = Traversal(0, SE2(), SE2(), 0.0, 0.0, EkfConfig())
    for _ in range(4):
        traversal.look(LandmarkView(0, 2.0, (LandmarkSighting(2.8, 0.0, 0.05, 0.02),), field))
    assert len(traversal.filter.landmarks) == 1
