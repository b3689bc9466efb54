"""When a recorded message counts as received."""

import struct

_TIME_LITTLE = struct.Struct("<iI")
_TIME_BIG = struct.Struct(">iI")

NEAR_NS = 10 * 10**9
"""A stamp further than this from the clock is of another time (a latched map, a wall clock) and is not used."""


class RecordingClock:
    """Gives each message its time: its own stamp where it has one, so that a bag does not depend on the machine.

    A run in lock-step goes at whatever speed the machine allows; reception by the wall clock would say nothing, and
    reception by simulated time depends on which of two topics arrived first. The stamp does not.
    """

    def __init__(self) -> None:
        """Know no time: it begins with the first stamp or the first message on /clock."""
        self.newest_ns: int | None = None
        """The newest time heard (ns): that of a message without a stamp."""
        self._clock_ns: int | None = None

    def tick(self, raw: bytes) -> int:
        """Take a message of /clock (its CDR bytes) and return its time (ns)."""
        time_ns = leading_stamp_ns(raw)
        # What was stamped before the clock was heard may be of another time: the clock decides.
        first = self._clock_ns is None or self.newest_ns is None
        self.newest_ns = time_ns if first else max(self.newest_ns or 0, time_ns)
        self._clock_ns = time_ns
        return time_ns

    def stamp_ns(self, raw: bytes) -> int | None:
        """Return a stamped message's time (ns): its stamp if near the clock, else the newest; None: none yet."""
        stamp_ns = leading_stamp_ns(raw)
        if stamp_ns < 0 or (self._clock_ns is not None and abs(stamp_ns - self._clock_ns) > NEAR_NS):
            return self.newest_ns
        self.newest_ns = max(self.newest_ns or 0, stamp_ns)
        return stamp_ns


def leading_stamp_ns(raw: bytes) -> int:
    """Return the time (ns) a CDR message begins with, after 4 bytes of encapsulation; -1 if it is too short for one."""
    if len(raw) < 12:
        return -1
    seconds, nanoseconds = (_TIME_LITTLE if raw[1] & 1 else _TIME_BIG).unpack_from(raw, 4)
    return int(seconds) * 10**9 + int(nanoseconds)
