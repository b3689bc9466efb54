"""Going slowly where the ring has not listened yet: sonar's silence is no evidence of free space, but patience is.

An edge answers three pings in ten at best.  Beside known walls the space between them has been listened to from many
places.  Driving away from all that is known, or right after a start, it has not: the slower the robot goes, the
more pings an edge must stay silent at before it is touched.
"""

import math

import numpy as np

from hslam_gvg.closest_points import ahead, beside
from hslam_gvg.config import GvgConfig
from hslam_gvg.trail import Trail
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SonarSweep, Velocity

ABREAST, BEHIND = -0.05, -0.35
"""Cosine of the angle from the way to the nearest obstacle of a side: still beside the way; left behind."""
STRIP_HALF_M, STRIP_M = 0.3, 1.5
"""Something known in this strip ahead: the way leads towards it, not into the unknown."""
NEXT_M = 0.45
"""How far ahead of its centre the body asks whether it has been listened there."""
BODY_NEXT_M = 0.15
"""Where its centre is about to be."""
EDGE_M = 2.0
"""An edge answers from this near at most."""
PINGS = 128
"""Some eight seconds of the Scout's ring: 16 sonars, one fired every 60 ms."""
BESIDE_WALLS, FROM_WALLS = 8.0, 20.0
"""Pings that are to listen to a place before the body is there, between known walls and away from all of them."""
PING_RATE = 1.4
"""Pings a second that listen to a place: the Scout's cones overlap a little and each sonar fires
once a second (another ring needs other numbers here)."""
TIGHT_M, AHEAD = 0.06, 0.5
"""Known obstacles nearer to the body than this stop it, if they lie within 60 deg (a cosine) of the way."""
TOGETHER_M = 0.1
"""Points within so much of that are of one obstacle."""
ONE, SEVERAL = 1, 3
"""Points that make an obstacle: off the edge any; along it a wall, an edge that answered thrice or a touch, which are
several, while echoes in mid-air are one or two."""
APPROACH_RATE = 0.8
"""Speed allowed for each metre of room (1/s)."""


class Caution:
    """Limits commands by what the map and the ring know of the way."""

    def __init__(self, config: GvgConfig) -> None:
        """Begin without having listened anywhere."""
        self._config = config
        self._pings = np.zeros((6, PINGS))
        """Transducer (m, odom), cosine and sine of its axis, how far it listened (m), cosine of its cone's half."""
        self._pings[4] = -1.0
        self._next = 0
        self.blocked = False
        """Whether the last command was stopped."""

    def hear(self, sweep: SonarSweep, poses: tuple[SE2, ...]) -> None:
        """Take a sweep's pings, answered or not; ``poses`` holds base_link in odom at each."""
        ring = sweep.ring
        least_cosine = math.cos(ring.cone_half_angle)
        for ping, pose in zip(sweep.pings, poses, strict=True):
            axis = pose.theta + ring.bearings[ping.sensor]
            c, s = math.cos(axis), math.sin(axis)
            x, y = pose.x + ring.mount_radius_m * c, pose.y + ring.mount_radius_m * s
            self._pings[:, self._next] = x, y, c, s, min(ping.range_m, EDGE_M), least_cosine
            self._next = (self._next + 1) % PINGS

    def listened(self, x: float, y: float) -> int:
        """Return how many of the last pings would have heard an edge at a place (m, odom), had it answered."""
        px, py, c, s, reach_m, least_cosine = self._pings
        dx, dy = x - px, y - py
        distance = np.sqrt(dx * dx + dy * dy)
        heard = (dx * c + dy * s >= least_cosine * distance) & (distance <= reach_m)
        return int(np.count_nonzero(heard))

    def limit(self, wanted: Velocity, base_in_odom: SE2, suspects: Array, trail: Trail, witnesses: int) -> Velocity:
        """Return the command at the pace that what is known allows; turning stays as wanted.

        Towards ``suspects`` (n x 2, m, odom) the body creeps at the end; so many ``witnesses`` together stop it.
        """
        config = self._config
        self.blocked = False
        speed = abs(wanted.forward)
        if speed == 0.0:
            return wanted
        x, y, heading = base_in_odom
        way = heading if wanted.forward > 0.0 else heading + math.pi
        c, s = math.cos(way), math.sin(way)
        if trail.has(x + BODY_NEXT_M * c, y + BODY_NEXT_M * s):
            return wanted
        dx, dy = suspects[:, 0] - x, suspects[:, 1] - y
        distance = np.sqrt(dx * dx + dy * dy)
        in_way = distance[dx * c + dy * s > AHEAD * distance]
        room_m = float(in_way.min()) - config.body_m - TIGHT_M if len(in_way) else math.inf
        if room_m <= 0.0 and np.count_nonzero(in_way < config.body_m + TIGHT_M + TOGETHER_M) >= witnesses:
            self.blocked = True
            return Velocity(0.0, wanted.turn)
        free_m = float(distance.min()) if len(distance) else config.reach_m
        # What the most listening would allow, first: what is needed takes longer to find out.
        listened = self.listened(x + NEXT_M * c, y + NEXT_M * s)
        allowed = _pace(free_m, FROM_WALLS - listened)
        if speed > allowed:
            allowed = _pace(free_m, self._needed(suspects, x, y, way) - listened)
        allowed = max(config.creep_m_s, min(allowed, APPROACH_RATE * room_m))
        return Velocity(math.copysign(min(speed, allowed), wanted.forward), wanted.turn)

    def _needed(self, suspects: Array, x: float, y: float, way: float) -> float:
        """Return how many pings are to listen ahead: more where what is known on either side lies behind."""
        sides = beside(suspects, x, y, way, self._config.reach_m)
        foremost = max((math.cos(side.bearing - way) for side in sides if side is not None), default=-1.0)
        if foremost >= ABREAST or ahead(suspects, x, y, way, STRIP_HALF_M, STRIP_M) < STRIP_M:
            return BESIDE_WALLS
        share = min(1.0, (ABREAST - foremost) / (ABREAST - BEHIND))
        return BESIDE_WALLS + share * (FROM_WALLS - BESIDE_WALLS)


def _pace(free_m: float, missing: float) -> float:
    """Return the speed (m/s) at which so many pings more are heard before the end of the free disc is reached."""
    return PING_RATE * free_m / missing if missing > 0.0 else math.inf
