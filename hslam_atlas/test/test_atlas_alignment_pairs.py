"""Known answers of the filter on the offset: which landmarks pair, in which order, and what a pair is worth."""

import math

import numpy as np
import pytest

from hslam_atlas.alignment import Alignment, PointMap, align
from hslam_types.se2 import SE2, Array

SURE = 1e-12 * np.eye(3)
"""Of an offset that is known."""


def points(*places: tuple[float, float], spread: Array | None = None, tied: bool = False) -> PointMap:
    """Return a map of places, each with the same 2 x 2 covariance (hardly any if not given)."""
    each = 1e-10 * np.eye(2) if spread is None else spread
    covariance = np.asarray(np.kron(np.eye(len(places)), each), dtype=np.float64)
    return PointMap(np.array(places), covariance, tied)


def aligned(
    existing: PointMap,
    candidate: PointMap,
    offset_covariance: Array = SURE,
    *,
    density: float = 1.0,
    noise_m: float = 0.0,
    terminal_noise_m: float = 0.0,
    gate: float = 9.2,
) -> Alignment:
    return align(
        existing, candidate, SE2(), offset_covariance,
        density=density, pair_noise_m=noise_m, terminal_noise_m=terminal_noise_m, gate=gate,
    )  # fmt: skip


@pytest.mark.parametrize("density", [0.5, 2.0])
@pytest.mark.parametrize(
    ("spread", "noise_m", "sigma_m"),
    [
        pytest.param([[0.04**2, 0.0], [0.0, 0.04**2]], 0.03, 0.05, id="round"),
        pytest.param([[0.05**2, 0.0], [0.0, 0.12**2]], 0.0, 0.12, id="long"),
        pytest.param([[0.01, 0.006], [0.006, 0.01]], 0.0, math.sqrt(0.016), id="askew"),
    ],
)
def test_a_pair_is_worth_its_likelihood_along_a_wall(
    spread: list[list[float]], noise_m: float, sigma_m: float, density: float
) -> None:
    """Of chi's two degrees of freedom one is along the wall, where landmarks stand by chance, too."""
    apart = np.array([0.05, 0.02])
    found = aligned(points((2.0, 1.0), spread=np.array(spread)), points((1.95, 0.98)), density=density, noise_m=noise_m)
    chi = float(apart @ np.linalg.solve(np.array(spread) + noise_m**2 * np.eye(2), apart))
    assert found.pairs == ((0, 0),)
    assert found.chi == pytest.approx(chi, rel=1e-5)
    assert found.freedom == 2
    assert found.sigma_m == pytest.approx(sigma_m, rel=1e-5)
    normal = density * math.sqrt(2.0 * math.pi) * sigma_m
    assert found.gain == pytest.approx(-0.25 * chi - math.log(normal), rel=1e-5)


def test_terminals_count_for_the_distance_of_the_maps_and_are_no_pair() -> None:
    existing, candidate = points((8.0, 0.0), (2.0, 1.0), tied=True), points((8.2, 0.0), (2.0, 1.0), tied=True)
    found = aligned(existing, candidate, terminal_noise_m=0.1)
    assert found.pairs == ((0, 0),)
    assert found.chi == pytest.approx(4.0, rel=1e-4)
    assert found.freedom == 4
    assert found.gain == pytest.approx(-math.log(math.sqrt(2.0 * math.pi) * found.sigma_m), abs=1e-4)


@pytest.mark.parametrize(("apart_m", "pairs"), [(0.303, 1), (0.304, 0)])
def test_the_gate_bounds_chi(apart_m: float, pairs: int) -> None:
    assert len(aligned(points((2.0, 0.0)), points((2.0, apart_m)), noise_m=0.1).pairs) == pairs


@pytest.mark.parametrize(("apart_m", "pairs"), [(1.45, 1), (1.55, 0)])
def test_however_unsure_the_offset_no_pair_is_made_from_afar(apart_m: float, pairs: int) -> None:
    assert len(aligned(points((2.0, 0.0)), points((2.0, apart_m)), np.diag([9.0, 9.0, 1e-6])).pairs) == pairs


def test_pairs_are_taken_from_the_origin_outward() -> None:
    places = ((5.0, 1.0), (1.0, 1.0), (-3.0, -1.0))
    found = aligned(points(*places), points(*places), noise_m=0.03)
    assert found.pairs == ((1, 1), (2, 2), (0, 0))


def test_a_landmark_with_two_likely_partners_waits_until_others_have_said_more() -> None:
    """The offset is 0.4 m.  The landmark about the origin lies nearer to the wrong one of two; the far one is alone."""
    existing = points((1.0, 0.0), (1.6, 0.0), (6.0, 0.0))
    found = aligned(existing, points((1.2, 0.0), (5.6, 0.0)), np.diag([0.09, 0.09, 1e-6]), noise_m=0.03)
    assert found.pairs == ((2, 1), (1, 0))
    assert found.offset.x == pytest.approx(0.4, abs=0.01)


def test_no_landmark_is_the_partner_of_two() -> None:
    found = aligned(points((2.0, 0.0)), points((2.0, 0.01), (2.0, -0.01)), noise_m=0.1)
    assert len(found.pairs) == 1


def test_the_offset_is_the_mean_of_prior_and_pairs_by_their_variances() -> None:
    """A prior of 0.1 m, and a landmark that says 0.3 m aside with 0.1 m: half way, with half the variance."""
    prior = np.diag([0.01, 0.01, 1e-12])
    found = aligned(points((0.0, 0.0)), points((-0.3, 0.0)), prior, noise_m=0.1)
    assert found.offset == pytest.approx((0.15, 0.0, 0.0), abs=1e-6)
    assert found.offset_covariance[0, 0] == pytest.approx(0.005, rel=1e-4)
