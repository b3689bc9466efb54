"""Known answers of what a match of two maps is worth."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scripted_level import edge_map

from hslam_atlas.alignment import Alignment
from hslam_atlas.config import AtlasConfig
from hslam_atlas.map_match import MapMatch, _density, _judge, match_constellations
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2

CONFIG = AtlasConfig(pair_gate=9.0, least_fraction=0.5, map_distance=2.5)
VISIBLE = 0.8


def alignment(pairs: int, *, gain: float = 0.0, chi: float = 0.0, sigma_m: float = 0.05) -> Alignment:
    """Return the outcome of an alignment with so many pairs."""
    empty = np.zeros((0, 0))
    mated = tuple((i, i) for i in range(pairs))
    return Alignment(SE2(), np.eye(3), mated, chi, max(2 * pairs, 1), gain, sigma_m, np.zeros(3), empty, empty)


def judged(
    pairs: int, expected_e: int, expected_c: int, *,
    gain: float = 50.0, chi: float = 0.0, sigma_m: float = 0.05, density: float = 1.0,
) -> MapMatch:  # fmt: skip
    found = alignment(pairs, gain=gain, chi=chi, sigma_m=sigma_m)
    return _judge(found, expected_e, expected_c, density, VISIBLE, CONFIG)


def furnished(landmarks: int, length_m: float, path_m: float = 0.0) -> EdgeMap:
    """Return a map with so many landmarks."""
    size = 2 + 2 * landmarks
    return EdgeMap(
        0, 1, length_m, np.zeros((landmarks, 2)), np.eye(size), (9,) * landmarks, 0.0, math.pi, SE2(),
        path_m or length_m,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("pairs", "expected_e", "expected_c", "fraction"), [(6, 6, 20, 0.3), (6, 20, 6, 0.3), (6, 8, 8, 0.75)]
)
def test_the_lesser_fraction_counts_whichever_map_holds_more(
    pairs: int, expected_e: int, expected_c: int, fraction: float
) -> None:
    match = judged(pairs, expected_e, expected_c)
    assert match.fraction == pytest.approx(fraction)
    assert match.agrees == (fraction >= 0.5)


@pytest.mark.parametrize(("pairs", "agrees"), [(2, False), (3, True)])
def test_two_pairs_are_chance(pairs: int, agrees: bool) -> None:
    assert judged(pairs, pairs, pairs).agrees == agrees


@pytest.mark.parametrize(("chi", "agrees"), [(2.49 * 20, True), (2.51 * 20, False)])
def test_the_distance_of_the_maps_is_chi_by_degrees_of_freedom(chi: float, agrees: bool) -> None:
    assert judged(10, 10, 10, chi=chi).agrees == agrees


@pytest.mark.parametrize(
    ("pairs", "expected", "sigma_m", "density", "shown", "chance"),
    [
        pytest.param(7, (10, 10), 0.05, 1.0, 0.7, 0.3, id="as much shown as is seen here"),
        pytest.param(9, (10, 10), 0.05, 1.0, VISIBLE, 0.3, id="no more than is ever shown"),
        pytest.param(3, (10, 20), 0.05, 1.0, 0.5, 0.3, id="no less than two maps of one place show"),
        pytest.param(7, (10, 10), 0.02, 1.0, 0.7, 0.12, id="surer maps, fewer chance neighbours"),
        pytest.param(7, (10, 10), 0.02, 2.0, 0.7, 0.24, id="denser walls, more of them"),
        pytest.param(7, (10, 10), 0.50, 1.0, 0.7, 0.5, id="only so much is excused"),
    ],
)
def test_evidence_weighs_pairs_and_what_is_left_alone(
    pairs: int, expected: tuple[int, int], sigma_m: float, density: float, shown: float, chance: float
) -> None:
    match = judged(pairs, *expected, gain=11.0, sigma_m=sigma_m, density=density)
    alone = sum(expected) - 2 * pairs
    assert match.evidence == pytest.approx(11.0 + pairs * math.log(shown) + alone * (math.log(1.0 - shown) + chance))


@pytest.mark.parametrize(
    ("pairs", "expected", "agrees"), [(12, 17, True), (12, 18, False), (11, 15, False), (40, 57, True)]
)
def test_against_evidence_only_many_pairs_match(pairs: int, expected: int, agrees: bool) -> None:
    match = judged(pairs, expected, expected, gain=-100.0)
    assert match.evidence < 0.0
    assert match.agrees == agrees


@pytest.mark.parametrize(
    ("maps", "density"),
    [
        ((furnished(30, 9.0), furnished(3, 9.0)), 1.0),
        ((furnished(3, 9.0), furnished(30, 9.0)), 1.0),
        ((furnished(30, 4.0, path_m=9.0), furnished(3, 9.0)), 1.0),
        ((furnished(1, 9.0), furnished(1, 9.0)), 0.2),
        ((furnished(300, 9.0), furnished(1, 9.0)), 3.0),
    ],
)
def test_density_is_that_of_the_better_furnished_map_over_two_walls_and_side_arms(
    maps: tuple[EdgeMap, EdgeMap], density: float
) -> None:
    assert _density(*maps) == pytest.approx(density)


def test_beyond_the_constellation_a_landmark_may_be_a_partner_but_is_not_missed() -> None:
    config = AtlasConfig()
    base = edge_map(0, 0)
    inner = [(1.0, 1.0), (2.0, -1.0), (3.0, 1.0), (4.0, -1.0)]
    beyond, far = [(5.3, 1.0), (5.6, -1.0)], [(9.0, 1.0)]

    def with_places(*places: tuple[float, float]) -> EdgeMap:
        size = 2 + 2 * len(places)
        covariance = 1e-4 * np.eye(size)
        return replace(base, landmarks=np.array(places), covariance=covariance, sightings=(9,) * len(places))

    prior = np.diag([0.0072, 0.0072, 1e-4])
    full, without = with_places(*inner, *beyond, *far), with_places(*inner)
    both, one = (match_constellations(full, other, SE2(), prior, config) for other in (full, without))
    assert len(both.alignment.pairs) == 6
    assert both.fraction == 1.0
    assert len(one.alignment.pairs) == 4
    assert one.fraction == 1.0
    # At the rim a scatter of centimetres decides whether a landmark is in: its partner counts as much.
    rim = with_places(*inner, (4.8, 1.0)), with_places(*inner, (5.0, 1.0))
    loose = replace(config, pair_noise_m=0.2)
    either_way = [match_constellations(*pair, SE2(), np.diag([0.09, 0.09, 1e-4]), loose) for pair in (rim, rim[::-1])]
    assert [match.fraction for match in either_way] == [1.0, 1.0]
    assert either_way[0].evidence == pytest.approx(either_way[1].evidence, abs=0.05)
