"""The simulated lidar: every beam ends at the first wall that answers it.

Each wall is asked for the beams it can cover, so that a scan costs in proportion to the walls in reach and not to
walls times beams.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hslam_sim.lidar_configuration import LidarConfiguration
from hslam_sim.passers_by import Disc
from hslam_sim.wall_index import BEHIND_M, WallIndex, Walls
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import RangeScan

Mask = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]


class Lidar:
    """Scans the walls of a world from a true pose."""

    def __init__(self, segments: Array, config: LidarConfiguration, rng: np.random.Generator) -> None:
        """Take the world's segments (n x 4, free space left) and the sensor's own generator."""
        self._config, self._rng = config, rng
        dark, glass = (
            _patches(segments, share, config.patch_m, rng) for share in (config.dark_share, config.glass_share)
        )
        # Light goes through a patch of glass as if it were not there.
        self._bright = WallIndex(segments[~glass & ~dark], config.range_max_m)
        self._dark = WallIndex(segments[~glass & dark], config.range_max_m)
        self._mounting = SE2(config.forward_m, 0.0, 0.0)
        self._step = config.bearing_step
        self._first = -0.5 * config.field_of_view
        bearings = [self._first + i * self._step for i in range(config.beams)]
        self._ray_x = np.array([math.cos(bearing) for bearing in bearings])
        self._ray_y = np.array([math.sin(bearing) for bearing in bearings])

    def scan(self, stamp_ns: int, base_in_map: SE2, discs: Sequence[Disc] = ()) -> RangeScan:
        """Return the ranges from a pose of base_link in map, +inf where nothing answers (REP-117).

        ``discs`` stand in the way besides the walls.
        """
        config, rng = self._config, self._rng
        noise, missing = rng.standard_normal(config.beams), rng.random(config.beams)
        sensor = base_in_map @ self._mounting
        ranges = self._first_hits(self._bright.near(sensor.x, sensor.y), sensor)
        for x, y, radius in discs:
            self._shade(ranges, x - sensor.x, y - sensor.y, radius, sensor.theta)
        swallowed = self._first_hits(self._dark.near(sensor.x, sensor.y), sensor) <= ranges
        ranges += config.noise_m * noise
        silent = swallowed | (missing < config.missing_probability) | (ranges > config.range_max_m)
        ranges[silent | (ranges < config.range_min_m)] = np.inf
        return RangeScan(
            stamp_ns, self._mounting, self._first, self._step, config.range_min_m, config.range_max_m, ranges
        )

    def _shade(self, ranges: Array, x: float, y: float, radius: float, heading: float) -> None:
        """Let a disc at a place relative to the sensor stop the beams that meet it."""
        c, s = math.cos(heading), math.sin(heading)
        ray_x, ray_y = c * self._ray_x - s * self._ray_y, s * self._ray_x + c * self._ray_y
        ahead, aside = ray_x * x + ray_y * y, ray_x * y - ray_y * x
        met = (np.abs(aside) < radius) & (ahead > 0.0)
        near = ahead[met] - np.sqrt(radius * radius - aside[met] * aside[met])
        ranges[met] = np.minimum(ranges[met], np.maximum(near, 0.0))

    def _first_hits(self, near: Walls, sensor: SE2) -> Array:
        """Return each beam's distance (m) to the first wall's face, +inf for none."""
        ranges = np.full(self._config.beams, np.inf)
        walls = near.facing(sensor.x, sensor.y, self._config.range_max_m)
        if not len(walls.length):
            return ranges
        off_x, off_y = walls.start_x - sensor.x, walls.start_y - sensor.y
        ahead = off_x * walls.tangent_y - off_y * walls.tangent_x
        wall, beam = self._covered(walls, off_x, off_y, sensor.theta)
        c, s = math.cos(sensor.theta), math.sin(sensor.theta)
        ray_x, ray_y = c * self._ray_x[beam] - s * self._ray_y[beam], s * self._ray_x[beam] + c * self._ray_y[beam]
        cosine = ray_x * walls.tangent_y[wall] - ray_y * walls.tangent_x[wall]
        along = off_x[wall] * ray_y - off_y[wall] * ray_x
        hit = (cosine > 1e-9) & (along >= 0.0) & (along <= walls.length[wall] * cosine) & (ahead[wall] > -BEHIND_M)
        np.minimum.at(ranges, beam[hit], np.maximum(ahead[wall[hit]], 0.0) / cosine[hit])
        return ranges

    def _covered(self, walls: Walls, off_x: Array, off_y: Array, heading: float) -> tuple[Indices, Indices]:
        """Return pairs of a wall's and a beam's number, of every wall with all beams that may meet it."""
        end_x, end_y = off_x + walls.length * walls.tangent_x, off_y + walls.length * walls.tangent_y
        # Seen from its face a wall runs counter-clockwise; how far its ends lie apart is at most half a turn.
        begin = (np.arctan2(off_y, off_x) - heading - self._first) % math.tau
        span = np.arctan2(off_x * end_y - off_y * end_x, off_x * end_x + off_y * end_y)
        span[span < 0.0] = 0.0
        pairs = []
        for turn in (0.0, -math.tau):
            # A beam more on either side: `_first_hits` decides, by arithmetic that rounds alike everywhere.
            low = np.maximum(np.floor((begin + turn) / self._step), 0.0).astype(np.int64)
            high = np.minimum(np.ceil((begin + span + turn) / self._step), self._config.beams - 1).astype(np.int64)
            count = np.maximum(high - low + 1, 0)
            wall = np.repeat(np.arange(len(count)), count)
            pairs.append((wall, np.arange(len(wall)) - np.repeat(np.cumsum(count) - count, count) + low[wall]))
        (wall_a, beam_a), (wall_b, beam_b) = pairs
        return np.concatenate((wall_a, wall_b)), np.concatenate((beam_a, beam_b))


def _patches(segments: Array, share: float, patch_m: float, rng: np.random.Generator) -> Mask:
    """Return which segments lie on patches of a kind, a mask of length n; patches are drawn along the walls."""
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    patch = (np.cumsum(length) / patch_m).astype(np.int64)
    drawn = rng.random(int(patch[-1]) + 1 if len(patch) else 0) < share
    mask: Mask = drawn[patch]
    return mask
