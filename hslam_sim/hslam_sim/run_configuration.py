"""What a run of the simulator's node is about: the world, and how its time passes."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter
from hslam_types.errors import ConfigurationError
from hslam_types.se2 import SE2


@dataclass(frozen=True)
class RunConfiguration(Configuration):
    """Which world, and how simulated time passes."""

    world: str = parameter("small_world", "name of a shipped world, or path of a world's or map_server's YAML file")
    start: str = parameter("", "where the robot stands, if not at the world's start: x and y (m) and heading (rad)")
    seed: int = parameter(0, "seed of every chance of the run", low=0, high=2**31 - 1)
    landmark_seed: int = parameter(0, "seed of the landmarks' places on the walls", low=0, high=2**31 - 1)
    lockstep: bool = parameter(True, "wait for the answers to a step before the next; otherwise run freely")
    real_time_factor: float = parameter(1.0, "simulated by wall time when running freely", low=0.01, high=100.0)
    warn_after_s: float = parameter(
        5.0, "lock-step: wall time until a missing answer is told", low=0.1, high=3600.0, unit="s"
    )
    fail_after_s: float = parameter(
        10.0, "lock-step: wall time until a missing answer ends the run", low=0.1, high=3600.0, unit="s"
    )
    start_within_s: float = parameter(
        60.0, "lock-step: wall time the nodes may take to answer the first step", low=0.1, high=3600.0, unit="s"
    )

    @property
    def start_in_world(self) -> SE2 | None:
        """Where the robot is to stand, None at the world's start; raises ConfigurationError where it says no pose."""
        if not self.start:
            return None
        try:
            x, y, heading = (float(word) for word in self.start.split())
        except ValueError:
            raise ConfigurationError(f"parameter 'start' must be x y heading, not '{self.start}'") from None
        return SE2(x, y, heading)
