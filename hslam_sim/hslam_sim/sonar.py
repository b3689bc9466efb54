"""The simulated sonar ring: first echo in a cone, from walls that mirror sound more than they scatter it.

A ping casts a fan of rays over the main lobe.  Each ray is stopped by the first wall; that wall answers only
if it is met near normal incidence.  Concave corners answer from anywhere in the cone, convex edges sometimes
and from near, side lobes hear a near wall at normal incidence only.  The first (nearest) echo wins.
"""

import math
from collections.abc import Sequence

import numpy as np

from hslam_sim.passers_by import Disc
from hslam_sim.point_index import PointIndex
from hslam_sim.reflectors import find_reflectors
from hslam_sim.sonar_configuration import SonarConfiguration
from hslam_sim.wall_index import WallIndex, Walls
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SonarPing, SonarRing

SCOUT_FIRING_ORDER = (0, 2, 15, 1, 14, 3, 13, 4, 12, 5, 11, 6, 10, 7, 9, 8)
"""The standard order of every Scout driver: neighbours are kept apart in time."""
HIDDEN_M = 0.01
"""A reflecting vertex is heard unless something stands this much nearer on the same ray."""


class SonarSimulator:
    """Fires the sonars of a ring, one at a time, in a world of walls."""

    def __init__(
        self, segments: Array, walls: WallIndex, ring: SonarRing, config: SonarConfiguration, rng: np.random.Generator
    ) -> None:
        """Take the world's segments (n x 4, free space left), their index, the ring and the sensor's own generator."""
        self._walls, self._ring, self._config, self._rng = walls, ring, config, rng
        corners, edges = find_reflectors(segments, config.corner_wall_m)
        # Columns: x, y, reach (m), chance of an answer.
        sure = np.broadcast_to([ring.range_max_m, 1.0], corners.shape)
        weak = np.broadcast_to([config.edge_range_m, config.edge_probability], edges.shape)
        points = np.vstack((np.hstack((corners, sure)), np.hstack((edges, weak))))
        self._vertices = PointIndex(points, ring.range_max_m + ring.mount_radius_m)
        count = 2 * math.ceil(ring.cone_half_angle / config.ray_spacing) + 1
        angles = [ring.cone_half_angle * (2 * i / (count - 1) - 1) for i in range(count)]
        self._fan_x = np.array([math.cos(a) for a in angles])
        self._fan_y = np.array([math.sin(a) for a in angles])
        self._cos_main, self._cos_side = math.cos(ring.cone_half_angle), math.cos(config.side_lobe_angle)

    def ping(self, number: int, stamp_ns: int, base_in_map: SE2, discs: Sequence[Disc] = ()) -> SonarPing:
        """Fire the ``number``-th ping (from 0) from a pose of base_link; every ping draws equally many numbers.

        ``discs`` answer besides the walls, from anywhere in the main lobe.
        """
        sensor = SCOUT_FIRING_ORDER[number % len(SCOUT_FIRING_ORDER)]
        chance = self._rng.random(6).tolist()
        noise = float(self._rng.standard_normal())
        bearing, mount = self._ring.bearings[sensor], self._ring.mount_radius_m
        axis = base_in_map.theta + bearing
        x, y = base_in_map.x + mount * math.cos(axis), base_in_map.y + mount * math.sin(axis)
        echo = self._first_echo(x, y, axis, chance[0], chance[1], chance[2])
        if discs:
            echo = min(echo, self._disc_echo(x, y, axis, np.array(discs)))
        return SonarPing(sensor, stamp_ns, self._reading(echo, noise, chance[3], chance[4], chance[5]))

    def _reading(self, echo: float, noise: float, spurious: float, where: float, missing: float) -> float:
        """Return what the board reports of a true first echo (m)."""
        ring, config = self._ring, self._config
        reading = echo * (1.0 + config.noise_fraction * noise) if echo < math.inf else math.inf
        if missing < config.missing_probability:
            reading = math.inf
        if spurious < config.spurious_probability:
            reading = ring.range_min_m + where * (min(reading, ring.range_max_m) - ring.range_min_m)
        if config.resolution_m > 0.0 and reading < math.inf:
            # The tiny share keeps a whole number of inches whole in binary arithmetic.
            reading = math.floor(reading / config.resolution_m + 1e-9) * config.resolution_m
        # The board's largest number means that nothing was heard.
        return max(reading, ring.range_min_m) if reading < ring.range_max_m else math.inf

    def _first_echo(self, x: float, y: float, axis: float, mirror: float, side: float, edge: float) -> float:
        """Return the distance (m) of the nearest reflector that answers a transducer at (x, y), +inf for none."""
        config = self._config
        ux, uy = math.cos(axis), math.sin(axis)
        facing = self._walls.near(x, y).facing(x, y, self._ring.range_max_m)
        # A little wider than the fan, so that a ray along the rim keeps the wall it ends on.
        rim = self._ring.cone_half_angle + 0.01
        right, left = (math.cos(axis - rim), math.sin(axis - rim)), (math.cos(axis + rim), math.sin(axis + rim))
        lobe = facing.within_wedge(x, y, right, left)
        vertex_x, vertex_y, vertex_m = self._vertices_in_cone(x, y, ux, uy, edge)
        rays_x = np.concatenate((ux * self._fan_x - uy * self._fan_y, vertex_x / vertex_m))
        rays_y = np.concatenate((uy * self._fan_x + ux * self._fan_y, vertex_y / vertex_m))
        distance, cosine = lobe.cast(x, y, rays_x, rays_y)
        limit = config.sure_incidence + mirror * (config.last_incidence - config.sure_incidence)
        fan = len(self._fan_x)
        answered = distance[:fan][cosine[:fan] >= math.cos(limit)]
        heard = vertex_m[distance[fan:] > vertex_m - HIDDEN_M]
        echoes = [*answered.tolist(), *heard.tolist()]
        if side < config.side_lobe_probability:
            echoes.append(self._side_echo(facing, x, y, axis, side))
        return min(echoes, default=math.inf)

    def _disc_echo(self, x: float, y: float, axis: float, discs: Array) -> float:
        """Return how far (m) the nearest disc (n x 3: place, radius) is that the main lobe meets before a wall."""
        off_x, off_y = discs[:, 0] - x, discs[:, 1] - y
        away = np.maximum(np.hypot(off_x, off_y), 1e-9)
        within = math.cos(axis) * off_x + math.sin(axis) * off_y > self._cos_main * away
        walls, _ = self._walls.near(x, y).cast(x, y, off_x / away, off_y / away)
        near = np.maximum(away - discs[:, 2], 0.0)
        return float(near[within & (near < walls)].min(initial=math.inf))

    def _side_echo(self, facing: Walls, x: float, y: float, axis: float, side: float) -> float:
        """Return the distance (m) of the nearest wall met at normal incidence by a side lobe, +inf for none."""
        off_x, off_y = facing.start_x - x, facing.start_y - y
        foot = off_x * facing.tangent_y - off_y * facing.tangent_x
        along = -(off_x * facing.tangent_x + off_y * facing.tangent_y)
        cosine = math.cos(axis) * facing.tangent_y - math.sin(axis) * facing.tangent_x
        weight = (cosine - self._cos_side) / (self._cos_main - self._cos_side)
        heard = (foot < self._config.side_lobe_range_m) & (foot > 0.0) & (along >= 0.0) & (along <= facing.length)
        heard &= (weight < 1.0) & (side < self._config.side_lobe_probability * weight)
        if not heard.any():
            return math.inf
        distance, _ = facing.cast(x, y, facing.tangent_y[heard], -facing.tangent_x[heard])
        seen = foot[heard][distance > foot[heard] - HIDDEN_M]
        return float(seen.min()) if len(seen) else math.inf

    def _vertices_in_cone(self, x: float, y: float, ux: float, uy: float, edge: float) -> tuple[Array, Array, Array]:
        """Return offsets x, y and distance (m) of the corners and the answering edges in the main lobe."""
        near = self._vertices.near(x, y)
        off_x, off_y = near[:, 0] - x, near[:, 1] - y
        distance = np.sqrt(off_x * off_x + off_y * off_y)
        inside = (off_x * ux + off_y * uy > self._cos_main * distance) & (distance < near[:, 2]) & (edge < near[:, 3])
        return off_x[inside], off_y[inside], distance[inside]
