"""What sonars hear at the moment, and where they have not listened yet, bound the pace before any map is sure."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

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
        self._reflex, self._caution, self._trail = Reflex(values), Caution(values), Trail()

    def hear(self, sweep: SonarSweep, bases: tuple[SE2, ...], base_in_odom: SE2, unexplained: Sequence[int]) -> None:
        """Take a sweep; ``bases`` holds base_link in odom at each ping.

        The reflex minds the ``unexplained`` pings alone (by number): off a wall that is known its points keep the body,
        where an echo's place on the axis would stop it in a narrow corridor.
        """
        self._trail.advance(base_in_odom.x, base_in_odom.y)
        minded = dataclasses.replace(sweep, pings=tuple(sweep.pings[i] for i in unexplained))
        self._reflex.hear(minded, tuple(bases[i] for i in unexplained))
        self._caution.hear(sweep, bases)

    def limited(self, wanted: Velocity, base_in_odom: SE2, obstacles: Array) -> tuple[Velocity, bool]:
        """Return the command that they allow, and whether it had to be stopped."""
        careful = self._caution.limit(wanted, base_in_odom, obstacles, self._trail, SEVERAL)
        command = self._reflex.limit(careful, base_in_odom)
        return command, self._caution.blocked or self._reflex.blocked
