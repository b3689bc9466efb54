"""Who still owes an answer to the present cycle, and when to say so: the heart of lock-step, free of ROS."""

from collections.abc import Sequence
from enum import Enum

from hslam_sim.errors import SimulatorError


class LockStepError(SimulatorError):
    """A node did not answer a cycle in time; the text names it."""


class Patience(Enum):
    """What a look at the clock asks for."""

    WAIT = "wait"
    WARN = "warn"


class LockStep:
    """Counts the answers to one cycle at a time; times are wall-clock seconds of any monotonic clock."""

    def __init__(self, answers: Sequence[str], warn_s: float, fail_s: float, start_s: float) -> None:
        """Take the names waited for, when to warn and when to fail; the first cycle may take ``start_s`` instead."""
        self._newest = dict.fromkeys(answers, -1)
        self._warn_s, self._fail_s, self._start_s = warn_s, fail_s, start_s
        self._stamp_ns = -1
        self._since_s = 0.0
        self._cycles = 0
        self._warned = False

    def expect(self, stamp_ns: int, now_s: float) -> None:
        """Begin to wait for every answer to the cycle ``stamp_ns``."""
        self._stamp_ns, self._since_s, self._warned = stamp_ns, now_s, False
        self._cycles += 1

    def answer(self, name: str, stamp_ns: int) -> None:
        """Note that ``name`` has handled everything up to ``stamp_ns``."""
        self._newest[name] = max(self._newest[name], stamp_ns)

    def missing(self) -> tuple[str, ...]:
        """Return who has not answered the present cycle, in the order given at the start."""
        return tuple(name for name, newest in self._newest.items() if newest < self._stamp_ns)

    def check(self, now_s: float) -> Patience:
        """Return WARN once a cycle when an answer is late; raises LockStepError when it is too late."""
        late_s = now_s - self._since_s
        missing = self.missing()
        if not missing:
            return Patience.WAIT
        limit_s = self._start_s if self._cycles <= 1 else self._fail_s
        if late_s > limit_s:
            raise LockStepError(
                f"gave up after {late_s:.0f} s at {self._stamp_ns * 1e-9:.2f} s of simulated time: "
                f"no answer from {', '.join(missing)}"
            )
        if late_s > self._warn_s and not self._warned:
            self._warned = True
            return Patience.WARN
        return Patience.WAIT
