"""How often different places look the same: the limit to what a match of maps can prove."""

import math

_PRIOR_WEIGHT = 100.0
"""Comparisons the prior is worth."""
_LOOKS_THE_SAME = 4.0
"""Evidence (nats) from which a comparison of different places counts as a look-alike."""


class LookAlikes:
    """Counts comparisons of places known to be different and those of them that matched."""

    def __init__(self, prior: float) -> None:
        """Start from the prior probability of a look-alike."""
        self._prior = prior
        self.compared = 0
        self.alike = 0

    def count(self, evidence: float) -> None:
        """Record the map evidence (nats) between two places that are certainly different."""
        self.compared += 1
        self.alike += int(evidence > _LOOKS_THE_SAME)

    def capped(self, evidence: float) -> float:
        """Return ``evidence`` limited by the chance of a look-alike: -log(exp(-evidence) + chance)."""
        chance = (self._prior * _PRIOR_WEIGHT + self.alike) / (_PRIOR_WEIGHT + self.compared)
        if evidence < -50.0:
            return evidence
        return -math.log(math.exp(-evidence) + chance)
