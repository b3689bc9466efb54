"""Lock-step seen from the emulator: it takes the next command once every node has answered the last state."""

import threading
import time
from collections.abc import Sequence

from hslam_ros.lock_step import LockStep, Patience


class Answers:
    """Shared between the thread that serves the line and the callbacks that hear the nodes' statuses."""

    def __init__(self, names: Sequence[str], warn_s: float, fail_s: float, start_s: float) -> None:
        """Take the names waited for, and the patience with them (wall seconds)."""
        self._names = frozenset(names)
        self._lock_step = LockStep(names, warn_s, fail_s, start_s)
        self._changed = threading.Condition()
        self._ended = self._complete = False

    def expect(self, stamp_ns: int) -> None:
        """A state has been reported: wait for the answers to it before the next."""
        with self._changed:
            self._lock_step.expect(stamp_ns, time.monotonic())

    @property
    def mission_complete(self) -> bool:
        """Whether a node has said that there is nothing left to do, and nobody owes an answer."""
        with self._changed:
            return self._complete and not self._lock_step.missing()

    def answer(self, name: str, stamp_ns: int, *, mission_complete: bool = False) -> None:
        """Note an answer."""
        with self._changed:
            if name in self._names:
                self._lock_step.answer(name, stamp_ns)
            self._complete |= mission_complete
            self._changed.notify_all()

    def wait(self) -> bool:
        """Wait until nobody owes an answer; False if the run ends meanwhile."""
        with self._changed:
            self._changed.wait_for(lambda: self._ended or not self._lock_step.missing())
            return not (self._ended or self._complete)

    def late(self) -> tuple[str, ...]:
        """Return whom to warn about now, if anybody; raises LockStepError when patience is at its end."""
        with self._changed:
            late = self._lock_step.check(time.monotonic()) is Patience.WARN
            return self._lock_step.missing() if late else ()

    def end(self) -> None:
        """Let whoever waits go."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
