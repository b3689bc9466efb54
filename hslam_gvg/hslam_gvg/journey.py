"""The path travelled along the edge under way, in odom, with the length along it."""

import math
from collections import deque

SPACING_M = 0.1
"""Of the remembered places."""
KEPT_M = 4.0
"""Longer than nodes are recognised behind the robot and than a branch's chord."""


class Journey:
    """Remembers the last metres of one edge and its whole length."""

    def __init__(self) -> None:
        """Begin at zero length, nowhere."""
        self.length_m = 0.0
        self._points: deque[tuple[float, float, float]] = deque()
        self._last: tuple[float, float] | None = None

    def begin(self, x: float, y: float) -> None:
        """Start a new edge at a place."""
        self.length_m = 0.0
        self._points.clear()
        self.resume(x, y)

    def resume(self, x: float, y: float) -> None:
        """Go on from a place without counting the way there."""
        self._last = (x, y)

    def advance(self, x: float, y: float) -> None:
        """Travel on to a place."""
        if self._last is not None:
            self.length_m += math.hypot(x - self._last[0], y - self._last[1])
        self._last = (x, y)
        if not self._points or self.length_m - self._points[-1][2] >= SPACING_M:
            self._points.append((x, y, self.length_m))
        while self.length_m - self._points[0][2] > KEPT_M:
            self._points.popleft()

    def places(self) -> list[tuple[float, float]]:
        """Return the remembered places, oldest first."""
        return [(x, y) for x, y, _ in self._points]

    def rewind(self, x: float, y: float) -> None:
        """Go back to the place on the path nearest to a given one: what came after it does not count."""
        if not self._points:
            return
        nearest = min(
            range(len(self._points)), key=lambda i: math.hypot(self._points[i][0] - x, self._points[i][1] - y)
        )
        while len(self._points) > nearest + 1:
            self._points.pop()
        self.length_m = self._points[-1][2]

    def came_from(self, x: float, y: float, back_m: float) -> float | None:
        """Return the direction (rad) from a place to where the path was ``back_m`` before its end."""
        if not self._points:
            return None
        wanted = self.length_m - back_m
        px, py, _ = min(self._points, key=lambda entry: abs(entry[2] - wanted))
        if math.hypot(px - x, py - y) < 0.1:
            return None
        return math.atan2(py - y, px - x)
