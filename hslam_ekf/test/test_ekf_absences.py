"""The counters of looks and absences against their rules, stated anew over the whole history of each landmark."""

from dataclasses import dataclass, field
from enum import Enum, auto

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hslam_ekf.config import EkfConfig
from hslam_ekf.landmark_evidence import LandmarkEvidence
from hslam_types.se2 import Array, wrap

CONFIG = EkfConfig(confirm_sightings=3, tentative_misses=4, keep_sightings=5, keep_fraction=0.5)
RANGE_M = 3.0
BEARINGS = (-3.14, 3.0, 0.0, 1.0, -1.0)
"""Of the landmarks; the first looks across the cut at pi."""


class Look(Enum):
    """What one look says of one landmark."""

    SEEN = auto()
    ABSENT = auto()
    HIDDEN = auto()
    """Something in front of it is seen."""
    BESIDE = auto()
    """Something farther away is seen, but not past it."""
    CLOSE_BEHIND = auto()
    """Too near to it to be told from it."""
    SEEN_PAST = auto()
    AWAY = auto()
    """Not in range."""


SIGHTINGS: dict[Look, tuple[tuple[float, float], ...]] = {
    Look.SEEN: ((0.1, 0.01),),
    Look.ABSENT: (),
    Look.HIDDEN: ((-1.0, 0.01),),
    Look.BESIDE: ((2.0, 0.06), (2.0, -0.06)),
    Look.CLOSE_BEHIND: ((0.4, 0.01),),
    Look.SEEN_PAST: ((0.6, -0.04), (1.5, 0.02)),
    Look.AWAY: ((2.0, 0.0),),
}
"""How the sightings of a look lie to the landmark (m behind it, rad beside it)."""


@dataclass
class History:
    """All looks at one landmark since its first sighting, and what follows from the rules by looking back."""

    looks: list[Look] = field(default_factory=lambda: [Look.SEEN])

    def sightings(self) -> int:
        """Return how often it was seen."""
        return self.looks.count(Look.SEEN)

    def absences(self) -> tuple[int, int]:
        """Return how many absences are misses, and how many may yet turn out to be."""
        last = max(i for i, look in enumerate(self.looks) if look is Look.SEEN)
        absent = [i for i, look in enumerate(self.looks) if look not in {Look.SEEN, Look.AWAY}]
        misses = [i for i in absent if i < last or self.looks[i] is Look.SEEN_PAST]
        return len(misses), len(absent) - len(misses)

    def mostly_seen(self) -> bool:
        """Tell whether half of the looks that ought to have shown it did."""
        return self.sightings() >= CONFIG.keep_fraction * (self.sightings() + self.absences()[0])

    def credible(self) -> bool:
        """Tell whether it is worth filtering on."""
        confirmed = self.sightings() >= CONFIG.confirm_sightings
        return self.mostly_seen() if confirmed else sum(self.absences()) < CONFIG.tentative_misses

    def lasting(self) -> bool:
        """Tell whether it is worth a place in the map."""
        return self.sightings() >= CONFIG.keep_sightings and self.mostly_seen()


def sightings_of(looks: list[tuple[float, Look]]) -> Array:
    """Return the sightings (m x 2) that looks at landmarks at the given bearings consist of."""
    seen = [(RANGE_M + far, wrap(bearing + beside)) for bearing, look in looks for far, beside in SIGHTINGS[look]]
    return np.array(seen).reshape(-1, 2)


ROUNDS = st.tuples(st.lists(st.sampled_from(Look), min_size=5, max_size=5), st.sampled_from([None] * 12 + [0, 1, 2]))
"""A look at each landmark, and which of those left is dropped after it."""


@given(st.lists(ROUNDS, max_size=30))
def test_every_absence_counts_once_and_only_when_it_says_something(rounds: list[tuple[list[Look], int | None]]) -> None:
    evidence = LandmarkEvidence(CONFIG)
    evidence.add(len(BEARINGS))
    left = {i: History() for i in range(len(BEARINGS))}
    for looks, dropped in rounds:
        now = {i: looks[i] for i in left}
        seen = np.array([k for k, i in enumerate(left) if now[i] is Look.SEEN], dtype=np.intp)
        in_range = np.array([k for k, i in enumerate(left) if now[i] is not Look.AWAY], dtype=np.intp)
        expected = np.array([(RANGE_M, BEARINGS[i]) for i in left if now[i] is not Look.AWAY]).reshape(-1, 2)
        evidence.count(seen, in_range, expected, sightings_of([(BEARINGS[i], look) for i, look in now.items()]))
        for i, look in now.items():
            left[i].looks.append(look)
        if dropped is not None and dropped < len(left):
            del left[list(left)[dropped]]
            evidence.keep(np.delete(np.arange(len(left) + 1), dropped))
        histories = list(left.values())
        assert evidence.sightings.tolist() == [history.sightings() for history in histories]
        assert evidence.misses.tolist() == [history.absences()[0] for history in histories]
        assert evidence.credible().tolist() == [k for k, history in enumerate(histories) if history.credible()]
        assert evidence.lasting().tolist() == [k for k, history in enumerate(histories) if history.lasting()]
