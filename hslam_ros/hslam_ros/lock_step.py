"""Who still owes an answer to the present cycle, and when to say so: the heart of lock-step, free of ROS."""

from collections.abc import Sequence
from enum import Enum

from hslam_ros.stamps import FOREVER_NS
from hslam_types.errors import HslamError


class LockStepError(HslamError):
    """A node did not answer a cycle in time; the text names it."""


class Patience(Enum):
    """What a look at the clock asks for."""

    WAIT = "wait"
    WARN = "warn"


class LockStep:
    """Counts the answers to one cycle at a time; times are wall-clock seconds of any monotonic clock.

    Some must answer a cycle before the next; others may trail by one, and work while the next is under way.
    """

    def __init__(
        self, prompt: Sequence[str], warn_s: float, fail_s: float, start_s: float, trailing: Sequence[str] = ()
    ) -> None:
        """Take the names waited for, when to warn and when to fail; the first cycles may take ``start_s`` instead."""
        self._newest = dict.fromkeys([*prompt, *trailing], -1)
        self._trailing = set(trailing)
        self._warn_s, self._fail_s, self._start_s = warn_s, fail_s, start_s
        self.stamp_ns = self._before_ns = -1
        """The present cycle."""
        self._since_s = 0.0
        self._starting = True
        self._warned = False

    def await_also(self, name: str) -> None:
        """Wait for one more from now on; it may trail."""
        self._newest.setdefault(name, -1)
        self._trailing.add(name)

    def expect(self, stamp_ns: int, now_s: float) -> None:
        """Begin to wait for the answers that the cycle ``stamp_ns`` needs before the next."""
        self._starting = min(self._newest.values(), default=0) < 0
        self._before_ns, self.stamp_ns = self.stamp_ns, stamp_ns
        self._since_s, self._warned = now_s, False

    def answer(self, name: str, stamp_ns: int) -> None:
        """Note that ``name`` has handled everything up to ``stamp_ns``: at most the present cycle, unless for ever."""
        handled_ns = stamp_ns if stamp_ns >= FOREVER_NS else min(stamp_ns, self.stamp_ns)
        self._newest[name] = max(self._newest[name], handled_ns)

    def missing(self) -> tuple[str, ...]:
        """Return whose answers the next cycle waits for, in the order given at the start."""
        now, before = self.stamp_ns, self._before_ns
        return tuple(
            name for name, newest in self._newest.items() if newest < (before if name in self._trailing else now)
        )

    def check(self, now_s: float) -> Patience:
        """Return WARN once a cycle when an answer is late; raises LockStepError when it is too late."""
        late_s = now_s - self._since_s
        missing = self.missing()
        if not missing:
            return Patience.WAIT
        limit_s = self._start_s if self._starting else self._fail_s
        if late_s > limit_s:
            raise LockStepError(
                f"gave up after {late_s:.0f} s at {self.stamp_ns * 1e-9:.2f} s of simulated time: "
                f"no answer from {', '.join(missing)}"
            )
        if late_s > self._warn_s and not self._warned:
            self._warned = True
            return Patience.WARN
        return Patience.WAIT
