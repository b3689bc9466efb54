"""The simulated landmark sensor: all round, unlabelled, noisy, with missed and false sightings.

It stands in for a camera under a mirror that finds coloured boxes along the walls (paper, section V).
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from hslam_sim.point_index import PointIndex
from hslam_sim.wall_index import WallIndex
from hslam_types.config import Configuration, parameter
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import LandmarkSighting, LandmarkView

BOX_DEPTH_M = 0.05
"""How far a box stands out from its wall: the wall it hangs on does not hide it."""


@dataclass(frozen=True)
class LandmarkConfiguration(Configuration):
    """What the sensor sees and how well; defaults assume a 640-pixel image of a hyperbolic mirror."""

    look_every: int = parameter(3, "simulation steps from one look to the next; 0: no such sensor", low=0, high=1000)
    range_max_m: float = parameter(6.0, "farthest box found", low=0.5, high=50.0, unit="m")
    range_std_m: float = parameter(0.02, "standard deviation of a range near by", low=0.0, high=1.0, unit="m")
    range_std_fraction: float = parameter(
        0.02, "standard deviation of a range that grows with it, added to the first", low=0.0, high=0.5
    )
    bearing_std: float = parameter(math.radians(1.0), "standard deviation of a bearing", low=0.0, high=0.5, unit="rad")
    missed_probability: float = parameter(0.1, "chance that a box in sight is not found", low=0.0, high=1.0)
    clutter_probability: float = parameter(
        0.2, "chance that a look holds one false sighting (about 1 % of sightings)", low=0.0, high=1.0
    )

    def due(self, step: int) -> bool:
        """Tell whether the sensor looks at a step (they count from 1)."""
        return self.look_every > 0 and step % self.look_every == 0

    def noise_free(self) -> Self:
        """Return a sensor that sees every box in sight exactly where it is (it still states small deviations)."""
        return dataclasses.replace(
            self, range_std_m=0.0, range_std_fraction=0.0, bearing_std=0.0, missed_probability=0.0,
            clutter_probability=0.0,
        )  # fmt: skip


class LandmarkSensor:
    """Looks at the landmarks of a world from a true pose."""

    def __init__(
        self, landmarks: Array, walls: WallIndex, config: LandmarkConfiguration, rng: np.random.Generator
    ) -> None:
        """Take landmarks (n x 2, m, on walls), the walls and the sensor's own generator."""
        self._points = PointIndex(landmarks, config.range_max_m)
        self._walls, self._config, self._rng = walls, config, rng

    def look(self, stamp_ns: int, base_in_map: SE2) -> LandmarkView:
        """Return the sightings from a pose of base_link in map, by bearing: nothing tells which box is which."""
        config, rng = self._config, self._rng
        range_m, bearing = self._in_sight(base_in_map)
        found = rng.random(len(range_m)) >= config.missed_probability
        noise = rng.standard_normal((len(range_m), 2))
        false = rng.random(3).tolist()
        sightings = [
            self._sighting(distance, direction, *errors)
            for distance, direction, errors, kept in zip(
                range_m.tolist(), bearing, noise.tolist(), found.tolist(), strict=True
            )
            if kept
        ]
        if false[0] < config.clutter_probability:
            # Uniform over the disc, so its range goes with the square root.
            sightings.append(self._sighting(config.range_max_m * math.sqrt(false[1]), math.tau * false[2], 0.0, 0.0))
        return LandmarkView(stamp_ns, config.range_max_m, tuple(sorted(sightings, key=lambda seen: seen.bearing)))

    def _sighting(self, range_m: float, bearing: float, range_error: float, bearing_error: float) -> LandmarkSighting:
        config = self._config
        range_std = config.range_std_m + config.range_std_fraction * range_m
        measured = max(range_m + range_std * range_error, 0.05)
        # A perfect sensor must still state deviations that a filter can invert.
        stated = max(config.range_std_m + config.range_std_fraction * measured, 1e-3), max(config.bearing_std, 1e-3)
        return LandmarkSighting(measured, wrap(bearing + config.bearing_std * bearing_error), *stated)

    def _in_sight(self, base: SE2) -> tuple[Array, list[float]]:
        """Return range (m) and bearing in base_link (rad) of every box with a free line of sight."""
        near = self._points.near(base.x, base.y)
        off_x, off_y = near[:, 0] - base.x, near[:, 1] - base.y
        distance = np.sqrt(off_x * off_x + off_y * off_y)
        close = (distance < self._config.range_max_m) & (distance > BOX_DEPTH_M)
        off_x, off_y, distance = off_x[close], off_y[close], distance[close]
        facing = self._walls.near(base.x, base.y).facing(base.x, base.y, self._config.range_max_m)
        blocked_at, _ = facing.cast(base.x, base.y, off_x / distance, off_y / distance)
        seen = blocked_at > distance - BOX_DEPTH_M
        directions = zip(off_y[seen].tolist(), off_x[seen].tolist(), strict=True)
        return distance[seen], [math.atan2(dy, dx) - base.theta for dy, dx in directions]
