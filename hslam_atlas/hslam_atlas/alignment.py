"""Align two edge-maps: an extended Kalman filter on the frame offset Q (eq. 7), landmark pairs by Mahalanobis distance.

The state joins the offset with both maps, X = [Q | E | C], so that every accepted pair also tells how the rest
of both maps must bend; the product of its innovations' likelihoods is that of the whole-map innovation with
S = P_E + G P_C G^T and the offset's share (eq. 8), taken in sequence.
"""

import math
from dataclasses import dataclass

import numpy as np

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
    covariance: Array
    """Posterior P."""


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
        innovation, spread, gathered = offset_filter.innovation(0, 0, terminal_noise_m)
        chi += _mahalanobis(innovation, spread)
        freedom += 2
        offset_filter.correct(innovation, spread, gathered)
    order = first_c + np.argsort(np.hypot(*candidate.points[first_c:].T), kind="stable")
    waiting = [int(j) for j in order]
    free = np.ones(len(existing.points), dtype=bool)
    free[:first_e] = False
    pairs: list[tuple[int, int]] = []
    sigma = pair_noise_m
    for rival in (_RIVAL, 0.0):
        left: list[int] = []
        for j in waiting:
            best = offset_filter.nearest(j, free, pair_noise_m)
            if best is None or best.chi > gate or best.lead < rival:
                left.append(j)
                continue
            offset_filter.correct(best.innovation, best.spread, best.gathered)
            free[best.existing] = False
            pairs.append((best.existing - first_e, j - first_c))
            chi += best.chi
            freedom += 2
            sigma = math.sqrt(float(np.linalg.eigvalsh(best.spread)[1]))
            gain += -0.25 * best.chi - math.log(density * math.sqrt(2.0 * math.pi) * sigma)
        waiting = left
    mean, covariance = offset_filter.mean, offset_filter.covariance
    x, y, theta = mean[:3].tolist()
    offset = SE2(x, y, wrap(theta))
    return Alignment(offset, covariance[:3, :3], tuple(pairs), chi, freedom, gain, sigma, mean, covariance)


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    existing: int
    chi: float
    lead: float
    innovation: Array
    spread: Array
    gathered: Array


class _OffsetFilter:
    """The joint state X = [Q | E | C] and its covariance."""

    def __init__(self, existing: PointMap, candidate: PointMap, prior: SE2, prior_covariance: Array) -> None:
        n, m = 2 * len(existing.points), 2 * len(candidate.points)
        self.mean = np.concatenate((np.array(prior), existing.points.ravel(), candidate.points.ravel()))
        self.covariance = np.zeros((3 + n + m, 3 + n + m))
        self.covariance[:3, :3] = prior_covariance
        self.covariance[3 : 3 + n, 3 : 3 + n] = existing.covariance
        self.covariance[3 + n :, 3 + n :] = candidate.covariance
        self._candidate = 3 + n

    def candidate_in_existing(self, j: int) -> tuple[float, float]:
        """Eq. 7: point ``j`` of the candidate in the existing map's frame."""
        qx, qy, theta = self.mean[:3].tolist()
        x, y = self.mean[self._candidate + 2 * j : self._candidate + 2 * j + 2].tolist()
        c, s = math.cos(theta), math.sin(theta)
        return qx + c * x - s * y, qy + s * x + c * y

    def innovation(self, i: int, j: int, noise_m: float) -> tuple[Array, Array, Array]:
        """Return e_i - Q(c_j), its covariance S and the gathered P H^T."""
        px, py = self.candidate_in_existing(j)
        qx, qy, theta = self.mean[:3].tolist()
        c, s = math.cos(theta), math.sin(theta)
        ie, jc = 3 + 2 * i, self._candidate + 2 * j
        ex, ey = self.mean[ie : ie + 2].tolist()
        h = np.array(
            [[-1.0, 0.0, py - qy, 1.0, 0.0, -c, s], [0.0, -1.0, qx - px, 0.0, 1.0, -s, -c]]
        )  # by Q, e_i and c_j
        columns = [0, 1, 2, ie, ie + 1, jc, jc + 1]
        gathered = self.covariance[:, columns] @ h.T
        spread = h @ gathered[columns] + noise_m**2 * np.eye(2)
        return np.array([ex - px, ey - py]), spread, gathered

    def nearest(self, j: int, free: Array, noise_m: float) -> _Pair | None:
        """Return the free existing landmark with the least Mahalanobis distance to candidate ``j``."""
        px, py = self.candidate_in_existing(j)
        points = self.mean[3 : self._candidate].reshape(-1, 2)
        near = np.flatnonzero(free & (np.abs(points[:, 0] - px) < _REACH_M) & (np.abs(points[:, 1] - py) < _REACH_M))
        best: _Pair | None = None
        second = math.inf
        for i in near.tolist():
            innovation, spread, gathered = self.innovation(i, j, noise_m)
            chi = _mahalanobis(innovation, spread)
            if best is None or chi < best.chi:
                second = math.inf if best is None else best.chi
                best = _Pair(i, chi, 0.0, innovation, spread, gathered)
            else:
                second = min(second, chi)
        if best is None:
            return None
        return _Pair(best.existing, best.chi, second - best.chi, best.innovation, best.spread, best.gathered)

    def correct(self, innovation: Array, spread: Array, gathered: Array) -> None:
        """Kalman update with the measurement "the pair is one point": the innovation must vanish (eqs. 4-6)."""
        gain = gathered @ np.linalg.inv(spread)
        self.mean = self.mean - gain @ innovation
        self.covariance = self.covariance - gain @ gathered.T
        self.covariance = 0.5 * (self.covariance + self.covariance.T)


def _mahalanobis(innovation: Array, spread: Array) -> float:
    """Chi of a 2-vector (eq. 3)."""
    (a, b), (_, d) = spread.tolist()
    x, y = innovation.tolist()
    return float((d * x * x - 2.0 * b * x * y + a * y * y) / (a * d - b * b))
