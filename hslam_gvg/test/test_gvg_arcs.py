"""What two arcs say about each other, on geometry with known answers."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_gvg.arc import WALL_SLACK, Arc, Arcs, median_azimuth, relate
from hslam_types.se2 import wrap

CONE = math.radians(15.0)


def one(arc: Arc) -> Arcs:
    return Arcs(*(np.array([value]) for value in arc))


def arc_to(x: float, y: float, target: tuple[float, float], off_axis: float = 0.0) -> Arc:
    dx, dy = target[0] - x, target[1] - y
    return Arc(x, y, math.atan2(dy, dx) + off_axis, math.hypot(dx, dy))


@given(st.floats(-CONE * 0.95, CONE * 0.95), st.floats(-CONE * 0.95, CONE * 0.95))
def test_arcs_of_one_corner_cross_at_the_corner(off_new: float, off_old: float) -> None:
    corner = (1.0, 0.5)
    new, old = arc_to(0.0, 0.0, corner, off_new), arc_to(1.0, -0.6, corner, off_old)
    found = relate(new, one(old), CONE, math.radians(30.0), 0.15)
    assert found.crosses[0]
    assert new.point(float(found.crossing[0])) == pytest.approx(corner, abs=1e-9)
    assert old.point(float(found.crossing_on_old[0])) == pytest.approx(corner, abs=1e-9)


def test_a_crossing_outside_a_cone_does_not_count() -> None:
    corner = (1.0, 0.5)
    new, old = arc_to(0.0, 0.0, corner, math.radians(20.0)), arc_to(1.0, -0.6, corner)
    assert not relate(new, one(old), CONE, math.radians(30.0), 0.15).crosses[0]


def test_a_crossing_outside_the_older_cone_does_not_count_either() -> None:
    corner = (1.0, 0.5)
    for off, crosses in ((math.radians(14.0), True), (math.radians(16.0), False)):
        new, old = arc_to(0.0, 0.0, corner), arc_to(1.0, -0.6, corner, off)
        assert relate(new, one(old), CONE, math.radians(30.0), 0.15).crosses[0] == crosses


def test_arcs_that_cross_at_a_small_angle_say_nothing() -> None:
    corner = (1.0, 0.5)
    new, old = arc_to(0.0, 0.0, corner), arc_to(1.0, -0.6, corner)
    between = abs(wrap(new.axis - old.axis))
    for least, crosses in ((between - 0.01, True), (between + 0.01, False)):
        assert relate(new, one(old), CONE, least, 0.15).crosses[0] == crosses


@pytest.mark.parametrize("turned", [0, 1])
def test_a_wall_whose_normal_either_sonar_cannot_hear_is_none(turned: int) -> None:
    for off, touches in ((CONE + WALL_SLACK - 0.01, True), (CONE + WALL_SLACK + 0.01, False)):
        axes = [math.pi / 2.0, math.pi / 2.0]
        axes[turned] += off
        new, old = Arc(0.0, 0.0, axes[0], 1.0), Arc(0.5, 0.0, axes[1], 1.0)
        assert relate(new, one(old), CONE, math.radians(30.0), 0.15).touches[0] == touches


@given(st.floats(0.25, 0.7), st.floats(0.5, 1.4), st.floats(-3.0, 3.0))
def test_arcs_of_one_wall_give_its_normal(apart: float, distance: float, turned: float) -> None:
    """Two sonars abreast of a wall at any direction of the wall; the arcs hardly cross."""
    along, normal = (math.cos(turned), math.sin(turned)), turned + math.pi / 2.0
    new = Arc(0.0, 0.0, normal, distance)
    old = Arc(apart * along[0], apart * along[1], normal, distance)
    found = relate(new, one(old), CONE, math.radians(30.0), 0.15)
    if apart > max(0.15, 0.12 * distance * distance):
        assert found.touches[0]
        assert abs(wrap(float(found.normal[0]) - normal)) < 1e-6
        assert found.wall_length[0] == pytest.approx(apart)


def test_a_short_base_tells_no_direction() -> None:
    new, old = Arc(0.0, 0.0, 1.57, 3.0), Arc(0.3, 0.0, 1.57, 3.0)
    assert not relate(new, one(old), CONE, math.radians(30.0), 0.15).touches[0]


def test_the_median_does_not_break_at_half_a_turn() -> None:
    azimuths = np.array([math.pi - 0.1, -math.pi + 0.1, math.pi - 0.05])
    assert abs(wrap(median_azimuth(azimuths, math.pi) - (math.pi - 0.05))) < 1e-9
