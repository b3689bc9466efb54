"""Driving along a path: towards a point ahead on it, slower where it is tight or turns."""

import math

import numpy as np

from hslam_gvg.driving.surroundings import Surroundings
from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.local_graph.polyline import arc_lengths, nearest
from hslam_types.se2 import Array, wrap
from hslam_types.sensing import Velocity

AHEADS = ((0.35, 0.25), (0.6, 0.35), (math.inf, 0.5))
"""Below which clearance (m) the point pursued lies so far (m) ahead."""
NEARER = (1.0, 0.7, 0.5, 0.3)
"""Shares of that distance, tried until the line there is clear."""
TOUCHING_M = 0.06
"""The nearest point pursued, where all farther ones are hidden: about one cell of the map."""
SEEN_M = 0.6
"""The clearance of the next so many metres sets the pace."""
SHARP, SHARP_WHERE_TIGHT, TIGHT_M = math.radians(50.0), math.radians(25.0), 0.35
"""Errors of direction beyond these are turned away on the spot."""


def pursue(path: Array, around: Surroundings, config: FollowConfig) -> Velocity:
    """Return the command along ``path`` (k x 3: x, y, clearance; m, odom) from where the robot is."""
    x, y, heading = around.pose
    index, off_m = nearest(path, x, y)
    rest = path[index:]
    along = arc_lengths(rest)
    room_m = float(rest[along < SEEN_M, 2].min(initial=float(rest[0, 2])))
    target = _target(rest, along, room_m, around)
    error = wrap(math.atan2(target[1] - y, target[0] - x) - heading)
    if abs(error) > SHARP or (abs(error) > SHARP_WHERE_TIGHT and room_m < TIGHT_M):
        return Velocity(0.0, math.copysign(min(config.turn_rad_s, 2.0 * abs(error) + 0.1), error))
    pace = config.cruise_m_s * min(1.0, max(0.3, (room_m - config.body_m) / 0.3))
    pace = min(pace, 0.08 + 0.8 * (float(along[-1]) + off_m)) * max(0.3, math.cos(error) ** 2)
    distance = math.hypot(target[0] - x, target[1] - y)
    curvature = 2.0 * math.sin(error) / max(distance, 0.15)
    if abs(pace * curvature) > config.turn_rad_s:
        pace = config.turn_rad_s / abs(curvature)
    return Velocity(pace, pace * curvature)


def _target(rest: Array, along: Array, room_m: float, around: Surroundings) -> tuple[float, float]:
    ahead_m = next(ahead for below, ahead in AHEADS if room_m < below)
    for way_m in (*(share * ahead_m for share in NEARER), TOUCHING_M):
        point = rest[min(int(np.searchsorted(along, way_m)), len(rest) - 1)]
        target = float(point[0]), float(point[1])
        if around.line_is_clear(*target):
            return target
    return target


def approach(x: float, y: float, around: Surroundings, config: FollowConfig) -> Velocity:
    """Return the command straight to a place (m, odom), backwards where that needs less turning."""
    dx, dy = x - around.pose.x, y - around.pose.y
    error = wrap(math.atan2(dy, dx) - around.pose.theta)
    backwards = abs(error) > 0.5 * math.pi
    if backwards:
        error = wrap(error + math.pi)
    turn = max(-config.turn_rad_s, min(config.turn_rad_s, 2.5 * error))
    pace = min(config.home_m_s, 0.04 + 0.8 * math.hypot(dx, dy)) if abs(error) < SHARP else 0.0
    return Velocity(-pace if backwards else pace, turn)
