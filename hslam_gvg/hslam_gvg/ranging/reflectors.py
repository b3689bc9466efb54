"""Where on its arc each echo came from: candidates, each a piece of wall that faces the sonar, weighed by all pings.

A wall answers a sonar that it faces (Leonard and Durrant-Whyte 1992), so every other ping says something of a
candidate: its echo agrees, which supports it; or it was fired along the candidate's normal and went past, which
contradicts it.  A wall met askew is never charged with silence.  An echo that a proven reflector explains has no
other cause; what nothing explains may be an edge (`hslam_gvg.ranging.edges`), or noise.
"""

import math

import numpy as np

from hslam_gvg.ranging.cone_ping import ConePing
from hslam_gvg.ranging.edges import EDGE_M, edges, suspicious
from hslam_gvg.ranging.rolling_grid import Mask
from hslam_types.se2 import Array

CAPACITY = 700
"""Echoes; where a slow robot hears more over `memory_m`, the oldest go."""
OFFSETS = np.linspace(-1.0, 1.0, 7)
"""Where on its arc an echo is placed on trial, in half cones from the axis."""
TOLERANCE_M, TOLERANCE_SHARE = 0.05, 0.02
"""A range agrees with a distance within these (an inch of rounding, 1 % of noise, odometry)."""
RIM_SLACK = math.radians(1.0)
"""What lies this little outside the cone may answer: heading is known no better."""
ASIDE_M = 0.45
"""A flat wall is heard as its piece by who stands no farther than so off the piece's normal."""
FACED, FACED_M = math.cos(math.radians(22.0)), 2.5
"""A wall that faces a sonar within this angle surely answers (specular above 25 to 30 degrees), from this near."""
PAST_M = 0.2
"""A ping heard this much farther than a candidate went past it: more than range noise and smoothing make."""
CONTRADICTED = 3.0
"""What one contradiction weighs, in supports: a wall that faces a sonar is hardly ever silent, but arcs often cross."""
LEVEL = 0.6
"""Candidates within so much of the best share the echo's place."""
PROVEN = 4.0
"""So much support makes a reflector that may explain other echoes."""
EXPLAINED_M, BESIDE_M = 0.06, 0.15
LOBE, SIDE_LOBE, SIDE_LOBE_M = math.cos(math.radians(20.0)), math.cos(math.radians(42.0)), 1.5
"""A wall is heard by the rim of a lobe, and from near by a side lobe out to where flat walls were measured to echo."""
PIECE_M, OTHER_PIECES = 0.4, 2
"""A wall is heard in pieces, so many of them this near to each; where echoes agree alone, there may be an edge."""
SUSPECTED_FOR_M = 3.0
"""What nothing explains is minded for so much travel."""
X, Y, AXIS, RANGE, HALF, BORN = range(6)


class Reflectors:
    """Echoes in memory with their candidates; places in odom (m)."""

    def __init__(self, reach_m: float, memory_m: float, need: float) -> None:
        """Begin empty; ``need`` is the support that makes an echo a reflector."""
        self._reach_m, self._memory_m, self._need = reach_m, memory_m, need
        self._count = 0
        self._echo = np.zeros((6, CAPACITY))
        """Transducer, axis, range, half cone, odometer reading."""
        self._candidate = np.zeros((4, CAPACITY, len(OFFSETS)))
        """Place x, y and normal x, y of each candidate; the normal points to the sonar."""
        self._support = np.zeros((CAPACITY, len(OFFSETS)))
        self._against = np.zeros((CAPACITY, len(OFFSETS)))
        self._silent = np.zeros((CAPACITY, len(OFFSETS)))
        """How many pings listened to each candidate from near and went past, at whatever angle."""
        self._proven: Array = np.zeros((0, 2))
        self._open = np.zeros(CAPACITY, bool)
        """Which echoes nothing explains."""

    def weigh(self, ping: Array) -> None:
        """Let a new ping (8, as `PingMemory` keeps it) speak for and against every candidate."""
        n = self._count
        support, against, silent = _witness(self._candidate[:, :n], ping)
        self._support[:n] += support
        self._against[:n] += against
        self._silent[:n] += silent

    def add(self, ping: ConePing, pings: Array, odometer_m: float) -> None:
        """Add the echo of a ping, weighed by the pings so far (8 x n, itself among them)."""
        if not ping.range_m < self._reach_m:
            return
        self._forget(odometer_m)
        n, azimuth = self._count, ping.axis + OFFSETS * ping.half_cone
        c, s = np.cos(azimuth), np.sin(azimuth)
        self._echo[:, n] = ping.x, ping.y, ping.axis, ping.range_m, ping.half_cone, odometer_m
        self._candidate[:, n] = ping.x + ping.range_m * c, ping.y + ping.range_m * s, -c, -s
        support, against, silent = _witness(self._candidate[:, n, :, None], pings[:, None, :])
        self._support[n] = np.count_nonzero(support, axis=1) - 1  # its own
        self._against[n] = np.count_nonzero(against, axis=1)
        self._silent[n] = np.count_nonzero(silent, axis=1)
        self._open[n] = not _explained(self._echo[:, n : n + 1], np.full((1, 2), math.inf), self._proven)[0]
        self._count = n + 1

    def explains(self, pings: tuple[ConePing, ...]) -> Mask:
        """Return which pings heard a reflector that was proven when the places were last asked for."""
        echo = np.array([(ping.x, ping.y, ping.axis, ping.range_m) for ping in pings]).reshape(-1, 4).T
        return _explained(echo, np.full((echo.shape[1], 2), math.inf), self._proven)

    def points(self, odometer_m: float) -> Array:
        """Return the places of the echoes that are believed, n x 2."""
        n = self._count
        rows = np.flatnonzero(self._echo[BORN, :n] > odometer_m - self._memory_m)
        if len(rows) == 0:
            return np.zeros((0, 2))
        echo, support, against = self._echo[:, rows], self._support[rows], self._against[rows]
        score = support - CONTRADICTED * against - 0.06 * np.abs(OFFSETS)
        best = score.argmax(axis=1)
        each = np.arange(len(rows))
        top, heard = score[each, best], support[each, best]
        level = score >= top[:, None] - LEVEL
        azimuth = echo[AXIS] + echo[HALF] * (level @ OFFSETS) / np.count_nonzero(level, axis=1)
        places = np.column_stack((echo[X] + echo[RANGE] * np.cos(azimuth), echo[Y] + echo[RANGE] * np.sin(azimuth)))
        believed = (heard >= self._need) & (top >= 0.75 * self._need)
        proven = believed & (heard >= PROVEN)
        self._proven = places[proven]
        explained = np.zeros(len(rows), bool)
        explained[~proven] = _explained(echo[:, ~proven], places[~proven], places[proven])
        chosen = believed & ~explained
        chosen[chosen] = _pieces(places[chosen])
        self._open[:n] = False
        self._open[rows[~chosen & ~explained]] = True
        loose = np.flatnonzero(~chosen & ~explained & (echo[RANGE] < EDGE_M))
        found, which = edges(self._candidate[:2, rows[loose]], echo[:, loose], self._silent[rows[loose]])
        self._open[rows[loose[which]]] = False
        return np.concatenate((places[chosen], found))

    def suspects(self, odometer_m: float) -> Array:
        """Return the places, n x 2, where near echoes may have come from that nothing explains yet."""
        n = self._count
        rows = np.flatnonzero(self._open[:n] & (self._echo[BORN, :n] > odometer_m - SUSPECTED_FOR_M))
        return suspicious(self._candidate[:2, rows], self._echo[RANGE, rows], self._silent[rows])

    def _forget(self, odometer_m: float) -> None:
        if self._count < CAPACITY:
            return
        kept = np.flatnonzero(self._echo[BORN] > odometer_m - self._memory_m)
        kept = kept[-(CAPACITY * 4 // 5) :]
        n = self._count = len(kept)
        self._echo[:, :n], self._candidate[:, :n] = self._echo[:, kept], self._candidate[:, kept]
        self._support[:n], self._against[:n] = self._support[kept], self._against[kept]
        self._silent[:n], self._open[:n] = self._silent[kept], self._open[kept]


def _witness(candidates: Array, pings: Array) -> tuple[Mask, Mask, Mask]:
    """Return which pings (8 first) speak for, and against, candidates (4 first), and which went past them."""
    px, py, nx, ny = candidates
    x, y, ux, uy, heard, _, rim, core = pings
    dx, dy = px - x, py - y
    distance = np.sqrt(dx * dx + dy * dy) + 1e-9
    on_axis, facing = (dx * ux + dy * uy) / distance, -(dx * nx + dy * ny) / distance
    aside = distance * np.sqrt(np.maximum(1.0 - facing * facing, 0.0))
    agrees = np.abs(distance - heard) < TOLERANCE_M + TOLERANCE_SHARE * heard
    support = agrees & (on_axis > rim - RIM_SLACK * np.sqrt(1.0 - rim * rim)) & (facing > 0.0) & (aside < ASIDE_M)
    past = (heard > distance + PAST_M) & (on_axis > core)
    return support, past & (facing > FACED) & (distance < FACED_M), past & (distance < EDGE_M)


def _pieces(places: Array) -> Mask:
    """Return which places (n x 2) are pieces of a wall, having others of it beside them."""
    apart = np.hypot(places[:, 0] - places[:, 0, None], places[:, 1] - places[:, 1, None])
    pieces: Mask = np.count_nonzero(apart < PIECE_M, axis=1) > OTHER_PIECES
    return pieces


def _explained(echo: Array, places: Array, proven: Array) -> Mask:
    """Return which echoes a proven reflector (m x 2) accounts for that is not the place itself (n x 2).

    Of an echo (rows of n) its place, axis and range are taken.
    """
    dx, dy = proven[:, 0] - echo[X][:, None], proven[:, 1] - echo[Y][:, None]
    distance = np.sqrt(dx * dx + dy * dy) + 1e-9
    heard, axis = echo[RANGE][:, None], echo[AXIS][:, None]
    on_axis = (dx * np.cos(axis) + dy * np.sin(axis)) / distance
    within = on_axis > np.where(heard < SIDE_LOBE_M, SIDE_LOBE, LOBE)
    agrees = np.abs(distance - heard) < EXPLAINED_M + TOLERANCE_SHARE * heard
    apart = np.hypot(proven[:, 0] - places[:, 0, None], proven[:, 1] - places[:, 1, None]) > BESIDE_M
    explained: Mask = (within & agrees & apart).any(axis=1)
    return explained
