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


@pytest.mark.parametrize(("known", "same"), [((0, 0, 50, 0), True), ((100, 1, 50, 1), True), ((100, 1, 50, 0), False)])
def test_where_places_look_alike_and_no_ways_do_each_way_speaks_for_itself(
    known: tuple[int, int, int, int], same: bool
) -> None:
    found = LookAlikes(1e-4, *known)
    at_once = found.joint([6.0, 8.0, 8.0, -3.0])
    if same:
        assert found.joint_by_ways(6.0, [8.0, 8.0, -3.0]) == at_once
        return
    way = -math.log(math.exp(-8.0) + 0.01 / 150.0)
    assert found.joint_by_ways(6.0, [8.0, 8.0, -3.0]) == pytest.approx(found.capped(6.0) + 2.0 * way - 3.0)
    assert found.joint_by_ways(-2.0, [8.0]) == pytest.approx(way - 2.0)
    assert found.joint_by_ways(0.0, [8.0]) == pytest.approx(way)


@pytest.mark.parametrize(("evidence", "alike"), [(3.9, 0), (4.1, 1)])
def test_ways_are_counted_apart_and_kept_by_name(evidence: float, alike: int) -> None:
    found = LookAlikes(1e-4, 5, 2)
    found.count_way(evidence)
    assert found.counts == {"compared": 5, "alike": 2, "ways_compared": 1, "ways_alike": alike}
    assert LookAlikes.from_counts(1e-4, found.counts).counts == found.counts
    assert LookAlikes.from_counts(1e-4, {"compared": 7}).counts == {
        "compared": 7, "alike": 0, "ways_compared": 0, "ways_alike": 0
    }  # fmt: skip
