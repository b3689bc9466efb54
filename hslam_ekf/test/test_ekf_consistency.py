"""Is the filter as sure as it may be: NEES and NIS over Monte Carlo drives, within chi-square bounds.

Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 5.4: averaged over
independent runs both must lie between the quantiles of a chi-square distribution.
"""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from hslam_ekf.server import EkfServer
from hslam_ekf.synthetic_drive import DriveErrors, corridor_landmarks, drive
from hslam_types.gvg_events import EventKind
from hslam_types.se2 import SE2, Array, wrap

PATH = np.array([[0.0, 0.0], [12.0, 0.0], [12.0, 9.0]])
RUNS = 20


def squared(error: Array, covariance: Array) -> float:
    """Return the normalised estimation error squared."""
    return float(error @ np.linalg.solve(covariance, error))


def pose_error(estimate: SE2, truth: SE2) -> Array:
    """Return estimate minus truth (3), the angle wrapped."""
    return np.array([estimate.x - truth.x, estimate.y - truth.y, wrap(estimate.theta - truth.theta)])


def measured(seed: int) -> dict[str, tuple[float, int]]:
    """Return normalised squared errors of one drive and their degrees of freedom."""
    rng = np.random.default_rng(seed)
    landmarks = corridor_landmarks(PATH, rng)
    bias = float(rng.normal(0.0, math.radians(1.2)))
    steps = drive(PATH, landmarks, DriveErrors(turn_bias_per_metre=bias, clutter=0.0), rng)
    start = SE2(0.0, 0.0, steps[0].base_in_map.theta)
    edge = SE2(0.0, 0.0, math.atan2(9.0, 12.0))
    server = EkfServer()
    found: dict[str, tuple[float, int]] = {}
    nis, freedom = 0.0, 0
    for step in steps:
        out = server.step(step.odom, step.view, step.events)
        if step.view is not None and server.traversal is not None:
            value, degrees = server.traversal.filter.nis
            nis, freedom = nis + value, freedom + degrees
        for edge_map in out.edge_maps:
            true = edge.inverse().apply_all(landmarks)
            gaps = np.linalg.norm(edge_map.landmarks[:, None] - true[None], axis=2)
            error = (edge_map.landmarks - true[gaps.argmin(axis=1)]).reshape(-1)
            rows = [0, *range(2, 2 + 2 * edge_map.size)]
            full = np.concatenate(([edge_map.terminal_x - 15.0], error))
            found["map"] = squared(full, edge_map.covariance[np.ix_(rows, rows)]), len(rows)
        arrives = any(event.kind is EventKind.ARRIVAL for event in step.events)
        if arrives or (out.base_in_edge is not None and not out.arrived):
            frame = edge if out.arrived else start
            true_pose = frame.to(step.base_in_map)
            assert out.base_in_edge is not None
            assert out.covariance is not None
            if np.linalg.eigvalsh(out.covariance).min() > 1e-9:
                found["arrived" if out.arrived else "pose"] = (
                    squared(pose_error(out.base_in_edge, true_pose), out.covariance),
                    3,
                )
        for link in out.links:
            next_frame = SE2(12.0, 9.0, step.base_in_map.theta)
            found["link"] = squared(pose_error(link.departure_in_edge, edge.to(next_frame)), link.covariance), 3
    return {**found, "nis": (nis, freedom)}


@pytest.fixture(scope="module")
def drives() -> list[dict[str, tuple[float, int]]]:
    """Return the figures of all drives."""
    return [measured(seed) for seed in range(RUNS)]


@pytest.mark.parametrize("figure", ["pose", "arrived", "link", "map"])
def test_nees(drives: list[dict[str, tuple[float, int]]], figure: str) -> None:
    total = sum(drive[figure][0] for drive in drives)
    freedom = sum(drive[figure][1] for drive in drives)
    low, high = float(chi2.ppf(0.0005, freedom)), float(chi2.ppf(0.9995, freedom))
    # Linearisation costs a large map some per cent.
    assert low < total < high * 1.1, (total / freedom, low / freedom, high / freedom)


def test_nis(drives: list[dict[str, tuple[float, int]]]) -> None:
    """Gating at 99.7 % and dropping beyond it cut the tail: the mean is 2 % under one."""
    ratio = sum(drive["nis"][0] for drive in drives) / sum(drive["nis"][1] for drive in drives)
    assert 0.94 < ratio < 1.03
