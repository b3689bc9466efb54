"""The rolling grid keeps what it shows where it is, however it moves."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hslam_gvg.ranging.rolling_grid import FREE, RollingGrid

place = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


def grid() -> RollingGrid:
    """Return a grid of 4 m by 4 m about the origin."""
    return RollingGrid(0.05, 2.0)


@given(st.lists(place, min_size=1, max_size=20), st.lists(place, max_size=5))
def test_points_stay_where_they_were_put_while_the_square_moves(
    points: list[tuple[float, float]], moves: list[tuple[float, float]]
) -> None:
    rolling = grid()
    rolling.occupy(np.array(points), 0.0)
    before = {tuple(p) for p in rolling.obstacle_points().tolist()}
    low = np.array([[-2.0, -2.0]])
    high = -low
    for x, y in moves:
        rolling.follow(x, y)
        low = np.maximum(low, np.array([[x, y]]) - 2.0 + 0.05)
        high = np.minimum(high, np.array([[x, y]]) + 2.0 - 0.05)
    after = {tuple(p) for p in rolling.obstacle_points().tolist()}
    assert after <= before
    inside = {p for p in before if (np.array(p) > low).all() and (np.array(p) < high).all()}
    # The square moves in strides of up to a metre, so a point well inside every square is still there.
    assert {p for p in inside if max(map(abs, p)) < 0.4} <= after


def test_what_falls_off_the_edge_does_not_come_back() -> None:
    rolling = grid()
    rolling.occupy(np.array([[1.9, 0.0]]), 0.0)
    rolling.follow(-5.0, 0.0)
    rolling.follow(0.0, 0.0)
    assert len(rolling.obstacle_points()) == 0


def test_the_newest_says_what_a_cell_is() -> None:
    rolling = grid()
    rolling.occupy(np.array([[0.51, 0.51]]), 0.0)
    mask = rolling.state == 2
    rolling.free(mask, 1.0)
    assert len(rolling.obstacle_points()) == 0
    assert rolling.is_free(np.array([0.51]), np.array([0.51])).all()
    assert (rolling.state[mask] == FREE).all()


def test_what_was_not_seen_again_is_forgotten() -> None:
    rolling = grid()
    rolling.occupy(np.array([[0.5, 0.5]]), 1.0)
    rolling.occupy(np.array([[-0.5, 0.5]]), 3.0)
    rolling.forget_before(2.0)
    assert rolling.obstacle_points().tolist() == [[-0.5, 0.5]]


def test_a_place_beyond_the_square_is_not_free() -> None:
    rolling = grid()
    rolling.free(np.ones((rolling.size, rolling.size), bool), 0.0)
    assert rolling.is_free(np.array([0.0, 9.0]), np.array([0.0, 0.0])).tolist() == [True, False]
