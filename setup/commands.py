"""Runs the commands of a set-up: what they print goes to a log, how far they are to whoever waits."""

import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from machine import SetUpError

_LOOK_S = 0.5
_BAR = 24
_LAST_LINES = 20


class CutShortError(SetUpError):
    """A command of the set-up was ended by a signal: what it was writing may be half written."""


@dataclass(frozen=True)
class Stand:
    """How far a command is."""

    share: float
    """Done, of 1."""
    text: str


def say(text: str) -> None:
    """Tell the person at the terminal what goes on."""
    sys.stdout.write(f"set-up: {text}\n")
    sys.stdout.flush()


class Display:
    """A line with a bar: on a terminal drawn over itself, elsewhere written at the start and with each quarter done."""

    def __init__(self, what: str, out: TextIO) -> None:
        """Show how far ``what`` is on ``out``."""
        self._what = what
        self._out = out
        self._started_s = time.monotonic()
        self._quarters = -1

    def show(self, stand: Stand) -> None:
        """Show where the command stands now."""
        minutes, seconds = divmod(int(time.monotonic() - self._started_s), 60)
        text = f"{stand.text}, {minutes}:{seconds:02d}"
        if self._out.isatty():
            full = int(_BAR * stand.share)
            line = f"set-up: {self._what} [{'#' * full}{'.' * (_BAR - full)}] {text}"
            self._out.write(f"\r{line[: shutil.get_terminal_size().columns - 1]}\x1b[K")
        elif (quarters := int(4 * stand.share)) > self._quarters:
            self._quarters = quarters
            self._out.write(f"set-up: {self._what}: {text}\n")
        self._out.flush()

    def close(self) -> None:
        """Leave the line."""
        if self._out.isatty():
            self._out.write("\n")
            self._out.flush()


class Commands:
    """Runs commands one after another; all that they print is in one log."""

    def __init__(self, log: Path, folder: Path, out: TextIO = sys.stdout) -> None:
        """Write to ``log``, which the first command begins anew; commands run in ``folder``."""
        self._log = log
        self._folder = folder
        self._out = out
        self._begun = False

    def run(
        self,
        command: Sequence[str],
        environment: Mapping[str, str],
        what: str,
        stand: Callable[[str], Stand] | None = None,
    ) -> None:
        """Run a command; ``stand`` tells from what it has printed how far it is.

        Raises SetUpError with the log's place where it fails, after showing its last lines.
        """
        self._log.parent.mkdir(parents=True, exist_ok=True)
        with self._log.open("a" if self._begun else "w") as log:
            self._begun = True
            log.write(f"==> {' '.join(command)}\n")
            log.flush()
            start = log.tell()
            unbuffered = dict(environment) | {"PYTHONUNBUFFERED": "1"}  # the log is looked into while it is written
            status = self._follow(
                subprocess.Popen(command, env=unbuffered, cwd=self._folder, stdout=log, stderr=subprocess.STDOUT),
                what,
                start,
                stand,
            )
        if not status:
            return
        sys.stderr.write("".join(self._printed(start).splitlines(keepends=True)[-_LAST_LINES:]))
        where = f"the whole output is in {self._log}"
        if status < 0:
            raise CutShortError(f"{what} was ended by {signal.Signals(-status).name}; {where}")
        raise SetUpError(f"{what} failed; {where}")

    def _follow(
        self, process: subprocess.Popen[bytes], what: str, start: int, stand: Callable[[str], Stand] | None
    ) -> int:
        """Return the exit status of a command, showing how far it is until it ends."""
        display = Display(what, self._out) if stand else None
        try:
            while True:
                try:
                    return process.wait(_LOOK_S)
                except subprocess.TimeoutExpired:
                    pass
                finally:
                    if stand and display:
                        display.show(stand(self._printed(start)))
        except KeyboardInterrupt:
            process.wait()  # the terminal has interrupted it as well
            raise
        finally:
            if display:
                display.close()

    def _printed(self, start: int) -> str:
        with self._log.open("rb") as log:
            log.seek(start)
            return log.read().decode(errors="replace")
