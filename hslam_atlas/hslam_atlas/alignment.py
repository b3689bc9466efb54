"""Align two edge-maps: an extended Kalman filter on the frame offset Q (eq. 7), landmark pairs by Mahalanobis distance.

The state joins the offset with both maps, X = [Q | E | C], so that every accepted pair also tells how the rest
of both maps must bend; the product of its innovations' likelihoods is that of the whole-map innovation with
S = P_E + G P_C G^T and the offset's share (eq. 8), taken in sequence.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hslam_types.se2 import SE2, Array, wrap

_REACH_M = 1.5
"""Farther apart two landmarks are never tried as a pair."""
_RIVAL = 4.0
"""A pair waits for a second pass unless it beats the next best by this much chi."""


@dataclass(frozen=True, slots=True, eq=False)
class PointMap:
    """Points with their joint covariance: the first one may be a terminal (``tied``), the rest are landmarks."""

    points: Array
    """n x 2, m."""
    covariance: Array
    """2n x 2n, m^2."""
    tied: bool
    """Whether point 0 is the terminal meet point, known to correspond to the other map's."""


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """The outcome: where the candidate frame lies in the existing one, what pairs, and the joint posterior."""

    offset: SE2
    """Q: pose of the candidate map's frame in the existing map's."""
    offset_covariance: Array
    """3 x 3."""
    pairs: tuple[tuple[int, int], ...]
    """Indices of associated landmarks (existing, candidate), the terminal not counted among either."""
    chi: float
    """Map distance (eq. 8) over the pairs, 2 degrees of freedom each, the terminal's included."""
    freedom: int
    """Degrees of freedom of ``chi``."""
    gain: float
    """Sum over the pairs of log(likelihood ratio) against landmarks scattered along walls (nats)."""
    sigma_m: float
    """Typical standard deviation of a pair's innovation at the end."""
    mean: Array
    """Posterior X = [Q | E | C]."""
    prior_covariance: Array
    """Prior P."""
    factors: Array
    """W, so that the posterior is P - W W^T."""

    def covariance(self) -> Array:
        """Return the posterior P: worked out only for maps that are to be fused."""
        spread: Array = self.prior_covariance - self.factors @ self.factors.T
        return spread


def align(
    existing: PointMap,
    candidate: PointMap,
    prior: SE2,
    prior_covariance: Array,
    *,
    density: float,
    pair_noise_m: float,
    terminal_noise_m: float,
    gate: float,
) -> Alignment:
    """Filter the offset from ``prior`` (covariance 3 x 3) through pairs taken outward from the origin.

    ``density``: landmarks per metre of wall, the background a pair is weighed against.
    """
    offset_filter = _OffsetFilter(existing, candidate, prior, prior_covariance)
    first_e, first_c = int(existing.tied), int(candidate.tied)
    chi, freedom, gain = 0.0, 0, 0.0
    if existing.tied and candidate.tied:
        terminals = offset_filter.innovation(0, 0, terminal_noise_m)
        chi += terminals.chi
        freedom += 2
        offset_filter.correct(terminals)
    order = first_c + np.argsort(np.hypot(*candidate.points[first_c:].T), kind="stable")
    waiting = [int(j) for j in order]
    free = np.ones(len(existing.points), dtype=bool)
    free[:first_e] = False
    pairs: list[tuple[int, int]] = []
    sigma = pair_noise_m
    for rival in (_RIVAL, 0.0):
        left: list[int] = []
        for j in waiting:
            best, lead = offset_filter.nearest(j, free, pair_noise_m)
            if best is None or best.chi > gate or lead < rival:
                left.append(j)
                continue
            offset_filter.correct(best)
            free[best.existing] = False
            pairs.append((best.existing - first_e, j - first_c))
            chi += best.chi
            freedom += 2
            sigma = _largest_std(best.spread)
            gain += -0.25 * best.chi - math.log(density * math.sqrt(2.0 * math.pi) * sigma)
        waiting = left
    x, y, theta = offset_filter.mean[:3].tolist()
    factors = offset_filter.factors()
    offset_covariance = prior_covariance - factors[:3] @ factors[:3].T
    return Alignment(
        SE2(x, y, wrap(theta)), offset_covariance, tuple(pairs), chi, freedom, gain, sigma,
        offset_filter.mean, offset_filter.prior, factors,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """The innovation of one pair, e_i - Q(c_j)."""

    existing: int
    chi: float
    innovation: Array
    spread: Array
    """S, 2 x 2."""
    columns: list[int]
    """Entries of X the innovation depends on."""
    jacobian: Array
    """Its derivative by them, 2 x 7."""


class _OffsetFilter:
    """The joint state X = [Q | E | C]; its covariance is kept as prior minus W W^T, two columns of W a pair.

    So a pair costs what its seven entries cost, not the square of both maps.
    """

    def __init__(self, existing: PointMap, candidate: PointMap, prior: SE2, prior_covariance: Array) -> None:
        n, m = 2 * len(existing.points), 2 * len(candidate.points)
        self.mean = np.concatenate((np.array(prior), existing.points.ravel(), candidate.points.ravel()))
        self.prior = np.zeros((3 + n + m, 3 + n + m))
        self.prior[:3, :3] = prior_covariance
        self.prior[3 : 3 + n, 3 : 3 + n] = existing.covariance
        self.prior[3 + n :, 3 + n :] = candidate.covariance
        self._candidate = 3 + n
        self._factors = np.zeros((3 + n + m, min(n, m) + 2))
        self._used = 0

    def factors(self) -> Array:
        """Return W as far as it goes."""
        return self._factors[:, : self._used]

    def candidate_in_existing(self, j: int) -> tuple[float, float]:
        """Eq. 7: point ``j`` of the candidate in the existing map's frame."""
        qx, qy, theta = self.mean[:3].tolist()
        x, y = self.mean[self._candidate + 2 * j : self._candidate + 2 * j + 2].tolist()
        c, s = math.cos(theta), math.sin(theta)
        return qx + c * x - s * y, qy + s * x + c * y

    def innovation(self, i: int, j: int, noise_m: float) -> _Pair:
        """Weigh existing point ``i`` and candidate ``j`` as a pair."""
        px, py = self.candidate_in_existing(j)
        qx, qy, theta = self.mean[:3].tolist()
        c, s = math.cos(theta), math.sin(theta)
        ie, jc = 3 + 2 * i, self._candidate + 2 * j
        ex, ey = self.mean[ie : ie + 2].tolist()
        h = np.array([[-1.0, 0.0, py - qy, 1.0, 0.0, -c, s], [0.0, -1.0, qx - px, 0.0, 1.0, -s, -c]])
        columns = [0, 1, 2, ie, ie + 1, jc, jc + 1]
        known = h @ self._factors[columns, : self._used]
        spread = h @ self.prior[np.ix_(columns, columns)] @ h.T - known @ known.T + noise_m**2 * np.eye(2)
        innovation = np.array([ex - px, ey - py])
        return _Pair(i, _mahalanobis(innovation, spread), innovation, spread, columns, h)

    def nearest(self, j: int, free: npt.NDArray[np.bool_], noise_m: float) -> tuple[_Pair | None, float]:
        """Return the free existing landmark with the least chi to candidate ``j``, and its lead over the next."""
        px, py = self.candidate_in_existing(j)
        points = self.mean[3 : self._candidate].reshape(-1, 2)
        near = np.flatnonzero(free & (np.abs(points[:, 0] - px) < _REACH_M) & (np.abs(points[:, 1] - py) < _REACH_M))
        ranked = sorted((self.innovation(i, j, noise_m) for i in near.tolist()), key=lambda pair: pair.chi)
        if not ranked:
            return None, 0.0
        return ranked[0], ranked[1].chi - ranked[0].chi if len(ranked) > 1 else math.inf

    def correct(self, pair: _Pair) -> None:
        """Kalman update with the measurement "the pair is one point": the innovation must vanish (eqs. 4-6)."""
        h, columns = pair.jacobian, pair.columns
        w = self._factors[:, : self._used]
        gathered = self.prior[:, columns] @ h.T - w @ (h @ w[columns]).T
        root = np.linalg.cholesky(pair.spread)
        step = np.linalg.solve(root, gathered.T).T
        self.mean = self.mean - step @ np.linalg.solve(root, pair.innovation)
        self._factors[:, self._used : self._used + 2] = step
        self._used += 2


def _mahalanobis(innovation: Array, spread: Array) -> float:
    """Chi of a 2-vector (eq. 3)."""
    (a, b), (_, d) = spread.tolist()
    x, y = innovation.tolist()
    return float((d * x * x - 2.0 * b * x * y + a * y * y) / (a * d - b * b))


def _largest_std(spread: Array) -> float:
    """Return the standard deviation along the longer axis of a 2 x 2 covariance."""
    (a, b), (_, d) = spread.tolist()
    return math.sqrt(0.5 * (a + d) + math.hypot(0.5 * (a - d), b))
