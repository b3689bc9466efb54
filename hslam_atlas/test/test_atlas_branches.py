"""Pairing branches between visits."""

import math

from hypothesis import given
from hypothesis import strategies as st

from hslam_atlas.branches import match_bearings
from hslam_types.se2 import wrap

GATE = math.radians(40.0)


def test_scattered_bearings_are_paired_in_order() -> None:
    known = [(0, 0.0), (1, 1.6), (2, -3.1)]
    assert match_bearings([1.5, 3.1, -0.1], known, GATE) == [1, 2, 0]


def test_a_missing_and_an_invented_branch() -> None:
    known = [(0, 0.0), (1, 1.57), (2, 3.14), (3, -1.57)]
    assert match_bearings([0.1, 3.0], known, GATE) == [0, 2]
    assert match_bearings([0.1, 0.9, 1.5], [(0, 0.0), (1, 1.57)], GATE) == [0, None, 1]


def test_who_would_have_to_cross_a_nearer_pair_finds_no_partner() -> None:
    """The branch seen at 1.0 lies within the gate of the one known at 1.6, but on the other side of the one at 1.39."""
    assert match_bearings([0.6, 1.0, 1.4], [(0, 1.39), (1, 0.62), (2, 1.6)], GATE) == [1, None, 0]


@given(
    st.integers(2, 6),
    st.floats(-math.pi, math.pi, exclude_max=True),
    st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6),
)
def test_small_scatter_never_confuses_well_separated_branches(degree: int, turn: float, scatter: list[float]) -> None:
    spacing = 2.0 * math.pi / degree
    known = [(k, wrap(turn + k * spacing)) for k in range(degree)]
    seen = [wrap(bearing + scatter[k] * min(1.0, spacing / 2.0)) for k, bearing in known]
    assert match_bearings(seen, known, GATE) == list(range(degree))


@given(st.lists(st.floats(-math.pi, math.pi), max_size=6), st.lists(st.floats(-math.pi, math.pi), max_size=6))
def test_pairs_are_one_to_one_and_within_the_gate(seen: list[float], bearings: list[float]) -> None:
    known = list(enumerate(bearings))
    keys = match_bearings(seen, known, GATE)
    found = [key for key in keys if key is not None]
    assert len(found) == len(set(found))
    assert all(abs(wrap(seen[i] - bearings[key])) < GATE for i, key in enumerate(keys) if key is not None)
