"""Known answers of the limit to what matches prove."""

import math

import pytest

from hslam_atlas.look_alikes import LookAlikes


@pytest.mark.parametrize(
    ("compared", "alike", "most"),
    [(0, 0, -math.log(1e-4)), (900, 0, -math.log(1e-5)), (900, 9, -math.log(9.01 / 1000.0)), (0, 10**6, 0.0)],
)
def test_no_match_is_worth_more_than_its_like_are_rare(compared: int, alike: int, most: float) -> None:
    """The prior counts as a hundred comparisons."""
    assert LookAlikes(1e-4, compared, alike).capped(1000.0) == pytest.approx(most, abs=1e-9)


def test_evidence_far_below_the_limit_is_worth_itself() -> None:
    assert LookAlikes(1e-4).capped(2.0) == pytest.approx(2.0, abs=1e-3)
    assert LookAlikes(1e-4).capped(-7.0) == pytest.approx(-7.0, abs=1e-3)


def test_matches_are_independent_until_a_look_alike_was_met() -> None:
    fresh, warned = LookAlikes(1e-4), LookAlikes(1e-4, 100, 1)
    assert fresh.joint([6.0, 6.0, -3.0]) == pytest.approx(2.0 * fresh.capped(6.0) - 3.0)
    assert warned.joint([6.0, 6.0, -3.0]) == pytest.approx(warned.capped(12.0) - 3.0)
    assert warned.joint([-3.0, -1.0]) == pytest.approx(-4.0)


@pytest.mark.parametrize(("evidence", "alike"), [(3.9, 0), (4.1, 1)])
def test_a_comparison_counts_as_alike_from_four_nats(evidence: float, alike: int) -> None:
    found = LookAlikes(1e-4)
    found.count(evidence)
    assert (found.compared, found.alike) == (1, alike)
