"""Who has answered a cycle of a replay in lock-step."""

from collections.abc import Sequence

from hslam_types.errors import HslamError


class NoAnswerError(HslamError):
    """A live node did not answer in time; the text names it."""


class Answers:
    """Counts the live nodes' answers to one cycle at a time; times are seconds of any monotonic clock."""

    def __init__(self, names: Sequence[str], start_s: float, patience_s: float) -> None:
        """Wait for ``names``, at most ``start_s`` for the first cycle and ``patience_s`` for each later one."""
        self._newest = dict.fromkeys(names, -1)
        self._start_s, self._patience_s = start_s, patience_s
        self._limit_s = start_s
        self._cycle_ns = -1
        self._since_s = 0.0

    def expect(self, cycle_ns: int, now_s: float) -> None:
        """Begin to wait for the answers to the cycle of time ``cycle_ns``."""
        self._limit_s = self._start_s if self._cycle_ns < 0 else self._patience_s
        self._cycle_ns, self._since_s = cycle_ns, now_s

    def take(self, name: str, stamp_ns: int) -> None:
        """Note that ``name`` has handled everything up to ``stamp_ns``."""
        self._newest[name] = max(self._newest[name], stamp_ns)

    def missing(self) -> tuple[str, ...]:
        """Return who has not answered yet."""
        return tuple(name for name, newest in self._newest.items() if newest < self._cycle_ns)

    def check(self, now_s: float) -> None:
        """Raise NoAnswerError, naming them, if some have not answered within the time they have."""
        missing = self.missing()
        if missing and now_s - self._since_s > self._limit_s:
            raise NoAnswerError(
                f"no answer from {', '.join(missing)} to the cycle at {self._cycle_ns * 1e-9:.2f} s "
                f"after {now_s - self._since_s:.0f} s; do they run, and hear all they wait for?"
            )
