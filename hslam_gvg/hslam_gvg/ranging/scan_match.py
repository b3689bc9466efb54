"""Where a scan fits the local map: odometry bends, and a bent map doubles its walls and opens them beside no way.

Point to line, iterated (Y. Chen and G. Medioni, "Object modelling by registration of multiple range images", 1992),
with the odometry since the last scan as prior: along a plain corridor the scan says nothing, and the odometry stays.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from hslam_types.se2 import SE2, Array
from hslam_types.sensing import RangeScan

ROUNDS = 4
"""Of Gauss-Newton; from a start this near it has converged by then."""
POINTS = 120
"""So many ends of a scan are matched at most."""
CHORD_M, MOST_BEAMS, BENT_M = 0.2, 8, 0.06
"""A surface's direction is that of a chord about so long, so many beams to either side at most; a bent one has none."""
LEAST_POINTS = 20
"""Fewer ends on walls say too little of three unknowns."""
POINT_STD_M, OUTLYING = 0.02, 2.0
"""Of an end from the line it belongs to; beyond so many of them it counts in proportion less (Huber)."""
SHARED = 4.0
"""So many neighbouring ends err alike: noise of the map, of the surface's direction."""
GATE_PER_METRE = 0.02
"""An end far away may lie farther off: a heading error takes it there."""


class Drift(NamedTuple):
    """What odometry may have gone wrong by since the last scan (standard deviations)."""

    way_m: float
    heading: float


class Surface(NamedTuple):
    """The ends of a scan whose surface has a direction, in base_link."""

    points: Array
    """n x 2 (m)."""
    normals: Array
    """n x 2, of length 1."""


def surface(scan: RangeScan, reach_m: float) -> Surface:
    """Return the ends of a scan out to ``reach_m`` with the normals of what they lie on, evenly thinned."""
    ranges, count = scan.ranges, len(scan.ranges)
    hit = (ranges >= scan.range_min_m) & (ranges <= min(reach_m, scan.range_max_m))
    angle = scan.bearings
    ends = np.where(hit, ranges, 0.0)[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    full = count * scan.bearing_step > math.tau - 0.5 * scan.bearing_step
    which = np.flatnonzero(hit)
    beams = np.clip(np.ceil(0.5 * CHORD_M / (ranges[which] * scan.bearing_step)), 1, MOST_BEAMS).astype(np.int64)
    low, high = which - beams, which + beams
    if full:
        low, high = low % count, high % count
    else:
        inside = (low >= 0) & (high < count)
        which, low, high = which[inside], low[inside], high[inside]
    along = ends[high] - ends[low]
    length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)
    normals = np.column_stack((-along[:, 1], along[:, 0])) / length[:, None]
    bent = np.abs(np.einsum("ij,ij->i", normals, ends[which] - 0.5 * (ends[low] + ends[high])))
    plain = hit[low] & hit[high] & (length < 4.0 * CHORD_M) & (bent < BENT_M)
    kept = np.flatnonzero(plain)
    kept = kept[:: max(1, math.ceil(len(kept) / POINTS))]
    return Surface(scan.sensor_in_base.apply_all(ends[which[kept]]), _turned(normals[kept], scan.sensor_in_base.theta))


def matched(seen: Surface, base_in_map: SE2, walls: Array, drift: Drift, gate_m: float) -> SE2:
    """Return the pose of base_link at which what is seen fits the walls (n x 2, m) best; as given where too few do."""
    if len(walls) < LEAST_POINTS or len(seen.points) < LEAST_POINTS:
        return base_in_map
    tree = cKDTree(walls)
    pose = base_in_map
    limit = gate_m + GATE_PER_METRE * np.hypot(seen.points[:, 0], seen.points[:, 1])
    prior = np.array([drift.way_m**-2, drift.way_m**-2, drift.heading**-2])
    for _ in range(ROUNDS):
        points, normals = pose.apply_all(seen.points), _turned(seen.normals, pose.theta)
        found = tree.query(points, distance_upper_bound=float(limit.max()))
        away, nearest = np.asarray(found[0]), np.asarray(found[1])
        near = away < limit
        if int(near.sum()) < LEAST_POINTS:
            return base_in_map
        points, normals = points[near], normals[near]
        off = np.einsum("ij,ij->i", normals, walls[nearest[near]] - points)
        arm_x, arm_y = points[:, 0] - pose.x, points[:, 1] - pose.y
        rows = np.column_stack((normals, normals[:, 1] * arm_x - normals[:, 0] * arm_y))
        weight = np.minimum(1.0, OUTLYING * POINT_STD_M / np.maximum(np.abs(off), 1e-9)) / (SHARED * POINT_STD_M**2)
        moved = np.array([base_in_map.x - pose.x, base_in_map.y - pose.y, base_in_map.theta - pose.theta])
        step = np.linalg.solve(
            rows.T @ (weight[:, None] * rows) + np.diag(prior), rows.T @ (weight * off) + prior * moved
        )
        pose = SE2(pose.x + float(step[0]), pose.y + float(step[1]), pose.theta + float(step[2]))
        if float(np.abs(step).max()) < 1e-4:
            break
    return pose


def _turned(vectors: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.column_stack((c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]))
