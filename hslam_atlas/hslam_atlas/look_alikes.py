"""How often different places look the same: the limit to what matching maps can prove.

A match against landmarks scattered at random would be near certainty; but floors repeat.  So places that cannot be
the same, because they are far apart, are compared too, and how often they match bounds what a match is worth.
Junctions of one kind look alike long before whole ways between them do: places and ways are counted apart.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Self

_PRIOR_WEIGHT = 100.0
"""Comparisons the prior is worth."""
_LOOKS_THE_SAME = 4.0
"""Evidence (nats) from which a comparison of different places counts as a look-alike."""


class LookAlikes:
    """Counts comparisons of what is known to be different, of places and of ways, and those of them that matched."""

    def __init__(
        self, prior: float, compared: int = 0, alike: int = 0, ways_compared: int = 0, ways_alike: int = 0
    ) -> None:
        """Start from the prior probability of a look-alike and the counts of earlier runs."""
        self._prior = prior
        self.compared, self.alike = compared, alike
        self.ways_compared, self.ways_alike = ways_compared, ways_alike

    @classmethod
    def from_counts(cls, prior: float, counts: Mapping[str, int]) -> Self:
        """Return what `counts` gave."""
        return cls(prior, *(counts.get(name, 0) for name in ("compared", "alike", "ways_compared", "ways_alike")))

    @property
    def counts(self) -> dict[str, int]:
        """The counts, by name, for an atlas file."""
        return {
            "compared": self.compared,
            "alike": self.alike,
            "ways_compared": self.ways_compared,
            "ways_alike": self.ways_alike,
        }

    def count(self, evidence: float) -> None:
        """Record the map evidence (nats) between two places that are certainly different."""
        self.compared += 1
        self.alike += int(evidence > _LOOKS_THE_SAME)

    def count_way(self, evidence: float) -> None:
        """Record the map evidence (nats) between two ways of one length that are certainly different."""
        self.ways_compared += 1
        self.ways_alike += int(evidence > _LOOKS_THE_SAME)

    def capped(self, evidence: float) -> float:
        """Return one match's evidence limited by the chance of a look-alike: -log(exp(-evidence) + chance)."""
        return self._limited(evidence, self.compared, self.alike)

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

    def joint_by_ways(self, place: float, ways: Iterable[float]) -> float:
        """Return what the match of a place and those of ways from it are worth together.

        Where places look alike but no two ways ever did, each way speaks for itself; else as `joint`.
        """
        known = (place,) if place else ()
        values: Sequence[float] = tuple(ways)
        if self.alike == 0 or self.ways_alike > 0:
            return self.joint((*known, *values))
        by_ways = sum(
            value if value < 0.0 else self._limited(value, self.ways_compared, self.ways_alike) for value in values
        )
        return self.joint(known) + by_ways

    def _limited(self, evidence: float, compared: int, alike: int) -> float:
        chance = (self._prior * _PRIOR_WEIGHT + alike) / (_PRIOR_WEIGHT + compared)
        return -math.log(math.exp(-max(evidence, -50.0)) + min(chance, 1.0))
