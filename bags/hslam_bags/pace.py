"""How a replay's time passes with the wall clock."""


class Pace:
    """Bag time from wall time at a rate, with pauses; both in nanoseconds, the wall's from any monotonic clock."""

    def __init__(self, start_ns: int, rate: float) -> None:
        """Begin at the bag's time ``start_ns``, at rest; ``rate`` is bag time by wall time."""
        self._rate = rate
        self._bag_ns = start_ns
        self._wall_ns: int | None = None

    @property
    def running(self) -> bool:
        """Whether time passes."""
        return self._wall_ns is not None

    def run(self, wall_ns: int) -> None:
        """Let time pass from now on."""
        if self._wall_ns is None:
            self._wall_ns = wall_ns

    def rest(self, wall_ns: int) -> None:
        """Stop time."""
        self._bag_ns = self.bag_ns(wall_ns)
        self._wall_ns = None

    def jump(self, bag_ns: int, wall_ns: int) -> None:
        """Go on from the bag's time ``bag_ns``."""
        self._bag_ns = bag_ns
        if self._wall_ns is not None:
            self._wall_ns = wall_ns

    def bag_ns(self, wall_ns: int) -> int:
        """Return the bag's time now."""
        if self._wall_ns is None:
            return self._bag_ns
        return self._bag_ns + round((wall_ns - self._wall_ns) * self._rate)
