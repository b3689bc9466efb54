"""People who walk about the floor, and things put down on it: discs that sensors see and that are on no plan.

A person walks straight on, turns away from walls and from the robot, and is polite: nobody walks into it.  Who is far
off comes in again nearer, so that a few are company on a large floor.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hslam_sim.wall_index import WallIndex
from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2

ROOM_M = 0.1
"""What people keep off walls and off the robot, besides their own width."""
TURNS = 8
"""So many directions are tried a step; who finds none stands."""
NEAR_M, FAR_M = 5.0, 12.0
"""Who is farther off than the second comes in again, at least as far off as the first."""
PLACES = 200
"""So many places are tried for who comes in; then nobody does in that step."""


class Disc(NamedTuple):
    """Something round on the floor (m, map)."""

    x: float
    y: float
    radius_m: float


@dataclass(frozen=True)
class PassersByConfiguration(Configuration):
    """Who walks about."""

    count: int = parameter(0, "people about the robot", low=0, high=100)
    radius_m: float = parameter(0.25, "half a person's width", low=0.05, high=1.0, unit="m")
    speed_m_s: float = parameter(0.8, "how fast they walk", low=0.0, high=3.0, unit="m/s")
    turn_every_s: float = parameter(6.0, "they turn about so often on average", low=0.1, high=600.0, unit="s")


class PassersBy:
    """The discs on the floor: people who walk, and things that stand."""

    def __init__(
        self, walls: WallIndex, config: PassersByConfiguration, body_m: float, rng: np.random.Generator
    ) -> None:
        """Take the walls, the robot's radius (m) and the people's own generator; they come in one by one."""
        self._walls, self._config, self._body_m, self._rng = walls, config, body_m, rng
        self._people: list[SE2] = []
        self._things: list[Disc] = []

    def put(self, thing: Disc) -> None:
        """Put something down on the floor, to stay."""
        self._things.append(thing)

    def take_away(self) -> None:
        """Take away what was put down."""
        self._things.clear()

    def discs(self) -> tuple[Disc, ...]:
        """Return everybody and everything."""
        return (*(Disc(pose.x, pose.y, self._config.radius_m) for pose in self._people), *self._things)

    def step(self, elapsed_s: float, robot: SE2) -> None:
        """Let everybody walk on for a while, round the robot."""
        if not self._config.count:
            return
        near = [pose for pose in self._people if math.hypot(pose.x - robot.x, pose.y - robot.y) < FAR_M]
        self._people = [self._walked(pose, elapsed_s, robot) for pose in near]
        if len(self._people) < self._config.count:
            self._come_in(robot)

    def _walked(self, pose: SE2, elapsed_s: float, robot: SE2) -> SE2:
        if self._rng.random() * self._config.turn_every_s < elapsed_s:
            pose = SE2(pose.x, pose.y, self._rng.uniform(-math.pi, math.pi))
        for _ in range(TURNS):
            to = pose @ SE2(self._config.speed_m_s * elapsed_s, 0.0, 0.0)
            if self._fits(to, robot):
                return to
            pose = SE2(pose.x, pose.y, self._rng.uniform(-math.pi, math.pi))
        return pose

    def _fits(self, pose: SE2, robot: SE2) -> bool:
        room_m = self._config.radius_m + ROOM_M
        off_robot_m = math.hypot(pose.x - robot.x, pose.y - robot.y) - self._body_m
        return off_robot_m > room_m and self._walls.near(pose.x, pose.y).clearance(pose.x, pose.y) > room_m

    def _come_in(self, robot: SE2) -> None:
        """Let one more be there, some way off on the floor."""
        for _ in range(PLACES):
            direction, way_m = self._rng.uniform(-math.pi, math.pi), self._rng.uniform(NEAR_M, 0.9 * FAR_M)
            x, y = robot.x + way_m * math.cos(direction), robot.y + way_m * math.sin(direction)
            pose = SE2(x, y, self._rng.uniform(-math.pi, math.pi))
            if self._inside(x, y) and self._fits(pose, robot):
                self._people.append(pose)
                return

    def _inside(self, x: float, y: float) -> bool:
        """Whether a place is on the floor: the wall nearest to it shows its face."""
        walls = self._walls.near(x, y)
        if not len(walls.length):
            return False
        off_x, off_y = x - walls.start_x, y - walls.start_y
        along = np.minimum(np.maximum(off_x * walls.tangent_x + off_y * walls.tangent_y, 0.0), walls.length)
        away = np.hypot(off_x - along * walls.tangent_x, off_y - along * walls.tangent_y)
        nearest = np.flatnonzero(away < away.min() + 1e-9)
        ahead = walls.tangent_x[nearest] * off_y[nearest] - walls.tangent_y[nearest] * off_x[nearest]
        return bool(ahead[np.argmax(np.abs(ahead))] > 0.0)
