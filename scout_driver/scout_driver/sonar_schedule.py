"""When each sonar was fired: the state frame holds sixteen readings of different ages and tells none of them.

The base fires one sonar every ping along the order it was given. The moment the sequence began is
known from the reply to CONF_SN, and is watched from then on: a reading that changes between two states
tells when its sonar was fired, give or take a cycle.
"""

import math

import numpy as np

from hslam_types.sensing import SonarPing
from scout_driver.config import DriverConfig
from scout_driver.protocol.replies import State
from scout_driver.units import METRES_PER_INCH

BIN_S = 0.005
"""Resolution to which the beginning of the sequence is known."""
FORGET = 0.97
"""Share of the old evidence kept at each new change: some 30 changes, a few seconds, decide."""
PRIOR = 8.0
"""Weight of the reply to CONF_SN, in changes."""
SOUND_M_S = 343.0
RATE_UNIT_S = 0.004
NUDGE = 0.2
"""Share of a cycle by which one cycle may be shifted to meet the echoes."""


class SonarSchedule:
    """Dates the readings of successive states; hands out each firing once, oldest first."""

    def __init__(self, config: DriverConfig) -> None:
        """Know the firing order and rate; the phase comes from `restart` or from the readings."""
        self._order = config.firing_order()
        self._rank = {sensor: rank for rank, sensor in enumerate(self._order)}
        self._ping_s = config.sonar_rate * RATE_UNIT_S
        self._period_s = self._ping_s * len(self._order)
        self._settle_s, self._no_echo = config.sonar_settle_s, config.sonar_no_echo
        self._votes = np.zeros(max(1, round(self._period_s / BIN_S)))
        self._phase_s = 0.0
        self._previous: tuple[State, float] | None = None
        self._handed_out_s = -math.inf

    @property
    def phase_s(self) -> float:
        """When the first sonar of the order is fired, modulo the period (s, on the clock of the stamps)."""
        return self._phase_s

    def next_cycle_s(self, began_s: float, cycle_s: float) -> float:
        """Return how long after ``began_s`` the next cycle best begins: about ``cycle_s``, once an echo must be in.

        Only where a cycle is a whole number of pings can the two be brought into step.
        """
        if cycle_s < self._ping_s or abs(math.remainder(cycle_s, self._ping_s)) > 1e-6:
            return cycle_s
        late_s = math.remainder(began_s - self._phase_s - self._settle_s, self._ping_s)
        return cycle_s - min(max(late_s, -NUDGE * cycle_s), NUDGE * cycle_s)

    def restart(self, stamp_s: float) -> None:
        """Note that the sequence began at ``stamp_s``: its first sonar is fired one ping later."""
        self._votes[:] = 0.0
        self._vote(stamp_s + self._ping_s - BIN_S, stamp_s + self._ping_s + BIN_S, PRIOR)
        self._phase_s = (stamp_s + self._ping_s) % self._period_s
        self._previous = None
        self._handed_out_s = stamp_s

    def pings(self, state: State, stamp_s: float) -> list[tuple[float, SonarPing]]:
        """Return (moment of firing, ping) of every firing settled since the last call, oldest first.

        The pings carry the stamp 0; the caller knows how its clock maps to ROS time.
        """
        known = self._previous[0].sonar if self._previous is not None else state.sonar
        if self._previous is not None:
            self._learn(*self._previous, state, stamp_s)
        self._previous = state, stamp_s
        settled = stamp_s - self._settle_s
        # Half a ping of slack keeps a phase that has just been corrected from firing a sonar twice.
        oldest = max(self._handed_out_s + 0.5 * self._ping_s, settled - self._period_s + 0.5 * self._ping_s)
        number = math.ceil((oldest - self._phase_s) / self._ping_s - 1e-6)
        result = []
        while (fired_s := self._phase_s + number * self._ping_s) <= stamp_s + 1e-9:
            sensor = self._order[number % len(self._order)]
            if fired_s > settled + 1e-9 and state.sonar[sensor] == known[sensor]:
                break  # its echo may still be on its way; only a reading that has changed is known to be new
            if state.sonar[sensor] > 0:  # 0 is what a board shows before a sonar's first firing
                result.append((fired_s, SonarPing(sensor, 0, self._range_m(state.sonar[sensor]))))
            self._handed_out_s = fired_s
            number += 1
        return result

    def _range_m(self, inches: int) -> float:
        return math.inf if inches >= self._no_echo else inches * METRES_PER_INCH

    def _learn(self, before: State, before_s: float, after: State, after_s: float) -> None:
        """Weigh where the sequence may have begun by what changed between two states."""
        if after_s - before_s >= self._period_s / 2.0:
            return  # after so long a gap a change tells nothing
        changed = [s for s in self._order if before.sonar[s] != after.sonar[s]]
        if not changed or len(changed) > 2 + (after_s - before_s) / self._ping_s:
            return  # more changes than firings: a damaged frame
        self._votes *= FORGET
        for sensor in changed:
            flight_s = 2.0 * after.sonar[sensor] * METRES_PER_INCH / SOUND_M_S
            ago_s = flight_s + self._rank[sensor] * self._ping_s
            self._vote(before_s - ago_s, after_s - ago_s, 1.0)
        best = self._votes.max()
        current = self._votes[int(self._phase_s / BIN_S) % len(self._votes)]
        if best > current + 1.5:
            self._phase_s = self._middle_of_best(best)

    def _vote(self, low_s: float, high_s: float, weight: float) -> None:
        first, last = math.floor(low_s / BIN_S + 1e-6), math.ceil(high_s / BIN_S - 1e-6)
        bins = np.arange(first, max(last, first + 1)) % len(self._votes)
        self._votes[bins] += weight

    def _middle_of_best(self, best: float) -> float:
        """Return the middle of the run of bins that holds the first maximum (it may wrap around the end)."""
        high = self._votes >= best - 0.5
        start = int(self._votes.argmax())
        count = len(high)
        first = last = start
        while high[(first - 1) % count] and start - first < count:
            first -= 1
        while high[(last + 1) % count] and last - start < count:
            last += 1
        return (0.5 * (first + last + 1) * BIN_S) % self._period_s
