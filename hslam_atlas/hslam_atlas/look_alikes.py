"""How often different places look the same: the limit to what matching maps can prove.

A match against landmarks scattered at random would be near certainty; but floors repeat.  So places that cannot be
the same, because they are far apart, are compared too, and how often they match bounds what a match is worth.
"""

import math
from collections.abc import Iterable, Sequence

_PRIOR_WEIGHT = 100.0
"""Comparisons the prior is worth."""
_LOOKS_THE_SAME = 4.0
"""Evidence (nats) from which a comparison of different places counts as a look-alike."""


class LookAlikes:
    """Counts comparisons of places known to be different and those of them that matched."""

    def __init__(self, prior: float, compared: int = 0, alike: int = 0) -> None:
        """Start from the prior probability of a look-alike and the counts of earlier runs."""
        self._prior = prior
        self.compared = compared
        self.alike = alike

    def count(self, evidence: float) -> None:
        """Record the map evidence (nats) between two places that are certainly different."""
        self.compared += 1
        self.alike += int(evidence > _LOOKS_THE_SAME)

    def capped(self, evidence: float) -> float:
        """Return one match's evidence limited by the chance of a look-alike: -log(exp(-evidence) + chance)."""
        chance = (self._prior * _PRIOR_WEIGHT + self.alike) / (_PRIOR_WEIGHT + self.compared)
        return -math.log(math.exp(-max(evidence, -50.0)) + min(chance, 1.0))

    def joint(self, evidence: Iterable[float]) -> float:
        """Return what several matches about one question are worth together.

        Where nothing was ever seen twice they are independent; on a floor that repeats, one look-alike brings
        the next, and all of them count as one.
        """
        values: Sequence[float] = tuple(evidence)
        against = sum(value for value in values if value < 0.0)
        speaking = [value for value in values if value >= 0.0]
        if self.alike == 0:
            return against + sum(self.capped(value) for value in speaking)
        return against + (self.capped(sum(speaking)) if speaking else 0.0)
