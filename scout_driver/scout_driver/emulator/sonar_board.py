"""The emulated sonar board: one firing a ping along the order, each reading shown once its echo is back."""

import math
from collections import deque
from collections.abc import Callable, Sequence

from scout_driver.protocol.commands import ORDER_END, SONARS
from scout_driver.sonar_schedule import RATE_UNIT_S, SOUND_M_S
from scout_driver.units import METRES_PER_INCH

POWER_ON_RATE = 15
POWER_ON_ORDER = tuple(range(SONARS))
"""What the sonars do before CONF_SN is not known; firing in order of index makes a driver that forgets it show."""
INCHES_MAX = 255


class SonarBoard:
    """Sixteen registers of whole inches and the sequence that fills them."""

    def __init__(self, no_echo: int) -> None:
        """Begin firing at time zero; ``no_echo`` is what a register shows when nothing was heard."""
        self._no_echo = no_echo
        self.registers = [0] * SONARS
        self._echoes: deque[tuple[float, int, int]] = deque()
        self._order, self._ping_s = POWER_ON_ORDER, POWER_ON_RATE * RATE_UNIT_S
        self._fired, self.next_firing_s = 0, self._ping_s

    def configure(self, rate: int, order: Sequence[int], now_s: float) -> None:
        """CONF_SN: begin the order anew; its first sonar is fired one ping from now."""
        end = list(order).index(ORDER_END) if ORDER_END in order else len(order)
        self._order = tuple(sensor for sensor in order[:end] if sensor < SONARS)
        self._ping_s = max(1, rate) * RATE_UNIT_S
        self._fired, self.next_firing_s = 0, now_s + self._ping_s

    def tick(self, now_s: float, range_m: Callable[[int], float]) -> None:
        """Fire what is due and take over the echoes that have come back."""
        while self._order and self.next_firing_s <= now_s + 1e-9:
            sensor = self._order[self._fired % len(self._order)]
            inches = self._inches(range_m(sensor))
            flight_s = 2.0 * min(inches, INCHES_MAX) * METRES_PER_INCH / SOUND_M_S
            self._echoes.append((self.next_firing_s + flight_s, sensor, inches))
            self._fired += 1
            self.next_firing_s += self._ping_s
        while self._echoes and self._echoes[0][0] <= now_s + 1e-9:
            _, sensor, inches = self._echoes.popleft()
            self.registers[sensor] = inches

    def _inches(self, heard_m: float) -> int:
        return min(round(heard_m / METRES_PER_INCH), INCHES_MAX) if math.isfinite(heard_m) else self._no_echo
