"""What sonars hear at the moment, and where they have not listened yet, bound the pace before any map is sure."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from hslam_gvg.caution import SEVERAL, Caution
from hslam_gvg.config import GvgConfig
from hslam_gvg.safety import Reflex
from hslam_gvg.trail import Trail
from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SonarSweep, Velocity


@dataclass(frozen=True)
class RingGuardConfig(Configuration):
    """How careful the robot is where sonars are silent or have just answered."""

    stop_m: float = parameter(
        0.2, "room to an echo ahead below which the robot crawls; it stops at half of it, or if a second echo agrees",
        low=0.02, high=1.0, unit="m",
    )  # fmt: skip
    second_echo_m: float = parameter(
        0.3, "room to a second echo ahead below which it confirms the first", low=0.05, high=2.0, unit="m"
    )
    creep_m_s: float = parameter(0.06, "speed where the ring has not listened enough", low=0.01, high=1.0, unit="m/s")


class RingGuard:
    """The reflex on raw echoes and the caution about silence, one after the other."""

    def __init__(self, config: RingGuardConfig, body_m: float) -> None:
        """Begin without having listened."""
        values = GvgConfig.from_mapping(dataclasses.asdict(config) | {"body_m": body_m})
        self._second_echo_m = config.second_echo_m
        self._reflex, self._caution, self._trail = Reflex(values), Caution(values), Trail()

    def hear(self, sweep: SonarSweep, bases: tuple[SE2, ...], base_in_odom: SE2) -> None:
        """Take a sweep; ``bases`` holds base_link in odom at each ping."""
        self._trail.advance(base_in_odom.x, base_in_odom.y)
        self._reflex.hear(sweep, bases)
        self._caution.hear(sweep, bases)

    def limited(self, wanted: Velocity, base_in_odom: SE2, obstacles: Array) -> tuple[Velocity, bool]:
        """Return the command that they allow, and whether it had to be stopped."""
        careful = self._caution.limit(wanted, base_in_odom, obstacles, self._trail, SEVERAL)
        command = self._reflex.limit(careful, base_in_odom)
        return command, self._caution.blocked or self._reflex.blocked

    def stopping(self, base_in_odom: SE2, backwards: bool) -> Array:
        """Return the places (n x 2) of the echoes that stop a motion, none where it is not stopped by echoes."""
        near = [echo for echo in self._reflex.in_way(base_in_odom, backwards) if echo[0] < self._second_echo_m]
        return np.array([place for _, *place in near]).reshape(-1, 2)
