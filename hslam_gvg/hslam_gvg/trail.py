"""Where the body has been: space that is free for certain, and the way back out of a tight place."""

import math
from collections import deque

SPACING_M = 0.05
"""Of the places."""
KEPT_M = 3.0
"""Longer than the way back out of any tight place (`recoil_m`)."""
BESIDE_M = 0.12
"""A place this near the trail is free for the body too, within what odometry and touch can tell."""


class Trail:
    """The last metres driven, in odom, whatever the state they were driven in."""

    def __init__(self) -> None:
        """Begin nowhere."""
        self._places: deque[tuple[float, float]] = deque(maxlen=round(KEPT_M / SPACING_M))

    def advance(self, x: float, y: float) -> None:
        """Take the body's centre (m, odom)."""
        if not self._places or math.hypot(x - self._places[-1][0], y - self._places[-1][1]) >= SPACING_M:
            self._places.append((x, y))

    def has(self, x: float, y: float) -> bool:
        """Whether the body has lately been where its centre would be at (x, y)."""
        near = BESIDE_M * BESIDE_M
        # The latest places are the likeliest; a plain loop is what costs least here.
        for px, py in reversed(self._places):  # noqa: SIM110
            if (x - px) * (x - px) + (y - py) * (y - py) < near:
                return True
        return False

    def before(self, x: float, y: float, back_m: float) -> tuple[float, float]:
        """Return the latest place of the trail at least ``back_m`` from (x, y); its beginning where there is none."""
        for px, py in reversed(self._places):
            if math.hypot(x - px, y - py) >= back_m:
                return px, py
        return self._places[0] if self._places else (x, y)
