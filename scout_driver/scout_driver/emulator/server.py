"""Runs an emulated line on a real port, by the wall's clock or in lock-step with whoever is at the other end."""

import threading
from collections.abc import Callable

from scout_driver.clock import Clock
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.ports import Port

IDLE_S = 0.02
"""Longest wall time without looking at the clock: the world goes on while nobody speaks."""


class EmulatorServer:
    """Moves bytes between a port and an emulated line in a thread of its own."""

    def __init__(
        self,
        line: EmulatedLine,
        port: Port,
        clock: Clock,
        time_factor: float,
        on_state: Callable[[int], None] = lambda _: None,
        may_go_on: Callable[[], bool] = lambda: True,
    ) -> None:
        """Serve ``line`` on ``port``.

        Args:
            line: the base and its line.
            port: the computer's end.
            clock: emulated time.
            time_factor: emulated seconds a wall second, to turn waits into wall time.
            on_state: called with the board time (ms) of each state, before its first byte leaves.
            may_go_on: called before bytes from the computer are acted on; returns False to give them up.
                It may wait: that is what lock-step is made of.
        """
        self._line, self._port, self._clock, self._factor = line, port, clock, time_factor
        self._on_state, self._may_go_on = on_state, may_go_on
        self._unplugs, self._unplugged = line.unplugs, False
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="scout_emulator", daemon=True)
        self.failure: BaseException | None = None
        """What ended the thread early."""

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def stop(self) -> None:
        """End, and take the line away."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()
        self._port.unplug()

    def _serve(self) -> None:
        try:
            while not self._ended.is_set():
                self.turn()
        except Exception as error:  # noqa: BLE001  whoever owns the server raises it where it is seen
            self.failure = error

    def turn(self) -> None:
        """Wait for the next event and deal with it."""
        line, now_s = self._line, self._clock.now()
        event_s = line.next_event_s()
        wait_s = IDLE_S if event_s is None else min(IDLE_S, max(0.0, (event_s - now_s) / self._factor))
        data = self._port.read(wait_s)
        if data and not self._may_go_on():
            return
        if data:
            line.receive(data, self._clock.now())
        line.advance(self._clock.now())
        while line.state_stamps:
            self._on_state(line.state_stamps.popleft())
        if line.unplugs != self._unplugs:
            self._port.unplug()
            self._unplugs, self._unplugged = line.unplugs, True
        elif self._unplugged and line.plugged(self._clock.now()):
            self._port.plug()
            self._unplugged = False
        if out := line.transmit(self._clock.now()):
            self._port.write(out)
