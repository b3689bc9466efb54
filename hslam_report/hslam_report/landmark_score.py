"""How far the mapped landmarks lie from the true ones: within each edge-map, and in the pictures of the whole floor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from hslam_report.explored import PlacedEdgeMap
from hslam_types.se2 import SE2, Array, rotation

GATE_M = 1.0
"""A mapped landmark farther from every true one is a false one and has no error."""


@dataclass(frozen=True)
class LandmarkScore:
    """Errors of all edge-maps together."""

    rmse_edge_m: float
    """In the edge frames, each laid on its true meet points; NaN if no landmark was mapped.  Without closed edges."""
    rmse_chained_m: float
    """In the picture along shortest chains of edges, laid on the truth by one rigid motion."""
    rmse_global_m: float
    """In the picture by least squares, likewise."""
    nees_mean: float
    """Mean squared error over its covariance, per degree of freedom: 1 is consistent, above it overconfident."""
    mapped: int
    false: int
    """Mapped landmarks without a true one in reach."""


def score_landmarks(maps: Sequence[PlacedEdgeMap], true_landmarks: Array) -> LandmarkScore:
    """Return the errors of edge-maps against the world's landmarks (n x 2, m, in map)."""
    squared: list[float] = []
    nees: list[float] = []
    chained: list[Array] = []
    optimised: list[Array] = []
    truth: list[Array] = []
    matched = 0
    for placed in maps:
        rows, columns = associate(placed.frame_in_map.apply_all(placed.landmarks), true_landmarks)
        matched += len(rows)
        true_in_edge = placed.frame_in_map.inverse().apply_all(true_landmarks[columns])
        errors = () if placed.closed else placed.landmarks[rows] - true_in_edge
        for row, error in zip(rows.tolist(), errors, strict=not placed.closed):
            block = placed.covariance[2 + 2 * row : 4 + 2 * row, 2 + 2 * row : 4 + 2 * row]
            squared.append(float(error @ error))
            nees.append(float(error @ np.linalg.solve(block, error)) / 2.0)
        chained.append(placed.chained[rows])
        optimised.append(placed.optimised[rows])
        truth.append(true_landmarks[columns])
    mapped = sum(len(placed.landmarks) for placed in maps)
    if not matched:
        return LandmarkScore(math.nan, math.nan, math.nan, math.nan, mapped, mapped)
    target = np.concatenate(truth)
    return LandmarkScore(
        rmse_edge_m=math.sqrt(float(np.mean(squared))) if squared else math.nan,
        rmse_chained_m=_rmse_m(np.concatenate(chained), target),
        rmse_global_m=_rmse_m(np.concatenate(optimised), target),
        nees_mean=float(np.mean(nees)) if nees else math.nan,
        mapped=mapped,
        false=mapped - matched,
    )


def _rmse_m(picture: Array, target: Array) -> float:
    """Return the error of points laid on others by one rigid motion."""
    off = rigid_fit(picture, target).apply_all(picture) - target
    return math.sqrt(float((off**2).sum(axis=1).mean()))


def associate(mapped: Array, true: Array) -> tuple[Array, Array]:
    """Return indices (rows, columns) of one-to-one pairs of least total squared distance within the gate."""
    if len(mapped) == 0 or len(true) == 0:
        return np.empty(0, dtype=int), np.empty(0, dtype=int)
    near = np.flatnonzero(
        (true >= mapped.min(axis=0) - GATE_M).all(axis=1) & (true <= mapped.max(axis=0) + GATE_M).all(axis=1)
    )
    squared = ((mapped[:, None, :] - true[None, near, :]) ** 2).sum(axis=2)
    # Beyond the gate every distance costs the same, so far pairs never push near ones apart.
    rows, columns = linear_sum_assignment(np.minimum(squared, GATE_M**2))
    within = squared[rows, columns] < GATE_M**2
    return rows[within], near[columns[within]]


def rigid_fit(points: Array, target: Array) -> SE2:
    """Return the pose that maps ``points`` onto ``target`` (both n x 2) with least squares.

    Source: Umeyama, "Least-squares estimation of transformation parameters between two point patterns", 1991,
    without scale; in the plane the rotation has a closed form.
    """
    middle, there = points.mean(axis=0), target.mean(axis=0)
    a, b = points - middle, target - there
    theta = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    shift = there - rotation(theta) @ middle
    return SE2(float(shift[0]), float(shift[1]), theta)
