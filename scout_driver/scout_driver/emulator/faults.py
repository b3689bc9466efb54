"""Faults by chance, drawn from one seeded generator."""

from enum import Enum

import numpy as np

from scout_driver.emulator.config import FaultConfig


class ReplyFault(Enum):
    """What becomes of a command and its reply."""

    NONE = 0
    NAK = 1
    SILENT = 2
    DEAF = 3
    SHORT = 4
    REPEATED = 5
    LATE = 6


class Faults:
    """Decides what goes wrong next."""

    def __init__(self, config: FaultConfig, rng: np.random.Generator) -> None:
        """Take the chances and the generator to draw from."""
        self.config = config
        self._rng = rng
        self._bytes_at_risk = config.flipped + config.lost + config.doubled + config.late > 0.0
        self.struck = 0
        """Faults injected so far."""

    def damage(self, data: bytes) -> list[tuple[int, float]]:
        """Return what is left of ``data``: bytes, each with how long it and all after it are held back (s)."""
        if not self._bytes_at_risk:
            return [(byte, 0.0) for byte in data]
        config, damaged = self.config, []
        chances = self._rng.random((len(data), 4)).tolist()
        for byte, (flip, lose, double, late) in zip(data, chances, strict=True):
            held_s = config.late_s * float(self._rng.random()) if late < config.late else 0.0
            flipped = byte ^ (1 << int(self._rng.integers(8))) if flip < config.flipped else byte
            copies = 0 if lose < config.lost else 2 if double < config.doubled else 1
            damaged += [(flipped, held_s)] + [(flipped, 0.0)] * (copies - 1) if copies else []
            self.struck += (flipped != byte) + (copies != 1) + (held_s > 0.0)
        return damaged

    def for_reply(self) -> ReplyFault:
        """Draw what becomes of the next command."""
        config = self.config
        draw = float(self._rng.random())
        for fault, chance in (
            (ReplyFault.NAK, config.nak),
            (ReplyFault.SILENT, config.silent),
            (ReplyFault.DEAF, config.deaf),
            (ReplyFault.SHORT, config.short),
            (ReplyFault.REPEATED, config.repeated),
            (ReplyFault.LATE, config.late_reply),
        ):
            if draw < chance:
                self.struck += 1
                return fault
            draw -= chance
        return ReplyFault.NONE

    def held_back_s(self) -> float:
        """Draw how long a late reply is held back (s)."""
        return self.config.late_s * (0.5 + 0.5 * float(self._rng.random()))

    def unplugs(self) -> bool:
        """Draw whether the line is pulled out now."""
        pulled = self.config.unplugged > 0.0 and float(self._rng.random()) < self.config.unplugged
        self.struck += pulled
        return pulled
