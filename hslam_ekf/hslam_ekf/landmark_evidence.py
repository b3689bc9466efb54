"""What speaks for and against each landmark: how often it was seen, how often it ought to have been.

The filter knows no walls, so absence alone proves nothing: a landmark behind the corner is in range and
hidden.  Two absences count.  A landmark missed *between* two sightings of it was in view (a line of sight
opens and closes once on a drive along a corridor), and one is missed in plain view when something farther
away is seen past it.
"""

import numpy as np
import numpy.typing as npt

from hslam_ekf.association import Indices
from hslam_ekf.config import EkfConfig
from hslam_types.se2 import Array, wrap_all

Counts = npt.NDArray[np.int64]

_SEEN_PAST = 0.05
"""Sightings within this bearing (rad) of a landmark and behind it prove the line of sight to it free."""


class LandmarkEvidence:
    """Counters of all landmarks of one filter, in its order."""

    def __init__(self, config: EkfConfig) -> None:
        """Start without landmarks."""
        self._config = config
        self.sightings: Counts = np.zeros(0, dtype=np.int64)
        """How often each was seen."""
        self.misses: Counts = np.zeros(0, dtype=np.int64)
        """How often each ought to have been seen and was not."""
        self._unseen: Counts = np.zeros(0, dtype=np.int64)
        """Looks within range since the last sighting that may be misses or occlusion."""

    def add(self, count: int) -> None:
        """Append ``count`` landmarks just seen for the first time."""
        self.sightings = np.concatenate((self.sightings, np.ones(count, dtype=np.int64)))
        self.misses = np.concatenate((self.misses, np.zeros(count, dtype=np.int64)))
        self._unseen = np.concatenate((self._unseen, np.zeros(count, dtype=np.int64)))

    def keep(self, landmarks: Indices) -> None:
        """Forget all but the given landmarks."""
        self.sightings, self.misses = self.sightings[landmarks], self.misses[landmarks]
        self._unseen = self._unseen[landmarks]

    def count(self, seen: Indices, in_range: Indices, expected: Array, sightings: Array) -> None:
        """Enter a look of ``sightings`` (m x 2): landmarks ``seen``, and those ``in_range``, ``expected`` at k x 2."""
        self.sightings[seen] += 1
        self.misses[seen] += self._unseen[seen]
        self._unseen[in_range] += 1
        self._unseen[seen] = 0
        if len(sightings):
            beside = np.abs(wrap_all(expected[:, None, 1] - sightings[None, :, 1])) < _SEEN_PAST
            behind = sightings[None, :, 0] > expected[:, None, 0] + 0.5
            plain = in_range[(beside & behind).any(axis=1)]
            plain = plain[self._unseen[plain] > 0]
            self.misses[plain] += 1
            self._unseen[plain] -= 1

    def credible(self) -> Indices:
        """Return the landmarks worth filtering on: confirmed ones mostly seen when they ought to be, and fresh ones."""
        confirmed = self.sightings >= self._config.confirm_sightings
        absent = self._unseen + self.misses >= self._config.tentative_misses
        return np.flatnonzero(np.where(confirmed, self._mostly_seen(), ~absent))

    def lasting(self) -> Indices:
        """Return the landmarks worth a place in an edge-map."""
        return np.flatnonzero((self.sightings >= self._config.keep_sightings) & self._mostly_seen())

    def _mostly_seen(self) -> npt.NDArray[np.bool_]:
        """Tell, for each landmark, whether it was seen often enough for the looks that ought to have shown it."""
        return self.sightings >= self._config.keep_fraction * (self.sightings + self.misses)
