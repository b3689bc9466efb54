"""The extended Kalman filter of the paper's section III-A, in any frame: predict, expect, correct, augment.

State (eq. 1): X = [x y theta bias | x_1 y_1 ... x_n y_n], metres and radians, with covariance P.  The
correction touches P only through W = P H^T, of which H needs five columns a sighting, and keeps P symmetric
and positive: eq. 6 is computed as P - V V^T with V = W L^-T and S = L L^T.  P is one contiguous block of
exactly its size, so that BLAS subtracts the product in place: three times faster than a buffer with room to
grow, which NumPy must copy into, and a landmark is added only now and then.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dgemm, dtrsm
from scipy.linalg.lapack import dpotrf as cholesky

from hslam_ekf.association import Indices
from hslam_ekf.config import EkfConfig
from hslam_ekf.motion_model import ROBOT, move, move_jacobian, slip_noise, stated_noise
from hslam_ekf.range_bearing import locate, locate_jacobians, observe, observe_jacobians
from hslam_types.se2 import SE2, Array, wrap, wrap_all


class Expectation(NamedTuple):
    """What the filter expects to measure of k landmarks, and what the correction needs of them."""

    landmarks: Indices
    """Which landmarks, k."""
    sightings: Array
    """Expected range and bearing, k x 2."""
    gradient: Array
    """grad h, k x 2 x 5: by the robot's x, y, theta and the landmark's x, y."""
    spread: Array
    """H P H^T of each landmark alone, k x 2 x 2."""


class LandmarkFilter:
    """Robot and landmarks in one frame; knows nothing of edges, looks or association."""

    def __init__(self, base_in_frame: SE2, bias: float, bias_variance: float, config: EkfConfig) -> None:
        """Start with a pose known exactly (P zero, as the paper has it) and what is known of the rotation bias."""
        self._config = config
        self.mean: Array = np.array([*base_in_frame, bias])
        """X (dimension)."""
        self.covariance: Array = np.zeros((ROBOT, ROBOT))
        """P (dimension x dimension)."""
        self.covariance[3, 3] = bias_variance
        self.nis = (0.0, 0)
        """Normalised innovation squared of the last correction and its degrees of freedom."""

    @property
    def landmarks(self) -> Array:
        """Landmark positions (a view, n x 2)."""
        return self.mean[ROBOT:].reshape(-1, 2)

    def pose(self) -> tuple[SE2, Array]:
        """Return the robot's pose and its covariance (3 x 3)."""
        x, y, theta = self.mean[:3].tolist()
        return SE2(x, y, theta), self.covariance[:3, :3].copy()

    def predict(self, step: SE2, noise: Array | None = None) -> None:
        """Move the robot by an odometry ``step``: X = f(X, U) and eq. 2, which touches the robot's rows of P only.

        ``noise``: the step's covariance (3 x 3, in base_link before it); None: what the configuration makes of it.
        """
        robot, covariance = self.mean[:ROBOT], self.covariance
        biased = noise is None
        by_robot = move_jacobian(robot, step, biased=biased)
        spread = slip_noise(step, self._config) if noise is None else stated_noise(robot, noise)
        robot[:] = move(robot, step, biased=biased)
        covariance[:ROBOT] = by_robot @ covariance[:ROBOT]
        covariance[ROBOT:, :ROBOT] = covariance[:ROBOT, ROBOT:].T
        block = covariance[:ROBOT, :ROBOT] @ by_robot.T + spread
        covariance[:ROBOT, :ROBOT] = 0.5 * (block + block.T)

    def expect(self, landmarks: Indices) -> Expectation:
        """Return Z^ = h(X) of the given landmarks with grad h, which has five columns each, and its H P H^T."""
        pose, positions = self.mean[:3], self.landmarks[landmarks]
        gradient = np.concatenate(observe_jacobians(pose, positions), axis=2)
        columns = np.empty((len(landmarks), 5), dtype=np.intp)
        columns[:, :3] = (0, 1, 2)
        columns[:, 3] = ROBOT + 2 * landmarks
        columns[:, 4] = columns[:, 3] + 1
        block = self.covariance[columns[:, :, None], columns[:, None, :]]
        spread = gradient @ block @ gradient.transpose(0, 2, 1)
        return Expectation(landmarks, observe(pose, positions), gradient, spread)

    def correct(self, expected: Expectation, chosen: Indices, sightings: Array, noise: Array) -> None:
        """Update X and P (eqs. 4 to 6) by m sightings, with variances ``noise``, of the ``chosen`` of ``expected``."""
        count = len(chosen)
        if count == 0:
            self.nis = (0.0, 0)
            return
        own = ROBOT + 2 * expected.landmarks[chosen]
        touched = np.concatenate(([0, 1, 2], np.column_stack((own, own + 1)).ravel()))
        gradient = np.zeros((count, 2, 3 + 2 * count))
        gradient[:, :, :3] = expected.gradient[chosen, :, :3]
        rows = np.arange(count)
        gradient[:, :, 3:].reshape(count, 2, count, 2)[rows, :, rows] = expected.gradient[chosen, :, 3:]
        h = gradient.reshape(2 * count, -1)
        innovation = sightings - expected.sightings[chosen]
        innovation[:, 1] = wrap_all(innovation[:, 1])
        hp = h @ self.covariance[touched]  # W^T
        s = hp[:, touched] @ h.T
        s.flat[:: len(s) + 1] += noise.ravel()
        lower = cholesky(s, lower=True)[0]
        v = dtrsm(1.0, lower, hp.T, side=1, lower=1, trans_a=1, overwrite_b=1)  # W L^-T
        z = dtrsm(1.0, lower, innovation.reshape(-1, 1), lower=1)[:, 0]  # L^-1 (Z - Z^)
        self.mean += v @ z  # eqs. 4 and 5: K (Z - Z^) with K = W S^-1
        self.mean[2] = wrap(self.mean[2])
        # Eq. 6 in place; transposed, P is what BLAS takes for contiguous.
        self.covariance = dgemm(-1.0, v, v, beta=1.0, c=self.covariance.T, trans_b=1, overwrite_c=1).T
        self.nis = (float(z @ z), 2 * count)

    def augment(self, sightings: Array, noise: Array) -> None:
        """Add a landmark for each sighting (m x 2, variances ``noise`` m x 2) with its full cross-covariance."""
        old, new = len(self.mean), len(self.mean) + 2 * len(sightings)
        pose = self.mean[:3]
        by_pose, by_sighting = locate_jacobians(pose, sightings)
        gx = by_pose.reshape(-1, 3)
        cross = gx @ self.covariance[:3]
        block = cross[:, :3] @ gx.T
        block = 0.5 * (block + block.T)
        rows = np.arange(len(sightings))
        own = (by_sighting * noise[:, None, :]) @ by_sighting.transpose(0, 2, 1)
        block.reshape(len(rows), 2, len(rows), 2)[rows, :, rows] += 0.5 * (own + own.transpose(0, 2, 1))
        covariance = np.empty((new, new))
        covariance[:old, :old], covariance[old:, old:] = self.covariance, block
        covariance[old:, :old], covariance[:old, old:] = cross, cross.T
        self.replace(np.concatenate((self.mean, locate(pose, sightings).reshape(-1))), covariance)

    def keep(self, landmarks: Indices) -> None:
        """Marginalise all landmarks but the given ones."""
        kept = np.concatenate((np.arange(ROBOT), (ROBOT + 2 * landmarks[:, None] + np.arange(2)).reshape(-1)))
        self.replace(self.mean[kept], self.covariance[np.ix_(kept, kept)])

    def replace(self, mean: Array, covariance: Array) -> None:
        """Put the state and covariance of the same robot (and landmarks) in, for example in another frame."""
        self.mean = mean
        self.covariance = np.ascontiguousarray(covariance)
