"""The landmark filter on logs recorded by others: `python bench/ekf_real_logs.py [--data FOLDER] [mrclam] [dlr]`.

MRCLAM 6 (Leung et al., IJRR 2011) with ids against Vicon truth, DLR (Kurlbaum and Frese) with and without ids against
the batch optimum with ids: one flat filter, and filters started afresh every so many metres as along GVG edges.
ATE is the error of the online path after a rigid fit; a landmark's error likewise.
"""

import argparse
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import gtsam
import numpy as np

from hslam_ekf.config import EkfConfig
from hslam_ekf.landmark_filter import LandmarkFilter
from hslam_ekf.motion_model import slip_noise
from hslam_ekf.traversal import Traversal
from hslam_types.se2 import SE2, Array, wrap_all
from hslam_types.sensing import LandmarkSighting, LandmarkView

DATA = Path(__file__).parents[2] / "shared" / "landmark_data"
SIGHT_M = 4.4
"""DLR: no disc was found farther away."""
MISREAD_GATE = 30.0
"""A sighting whose chi exceeds this bears a wrong id (MRCLAM's barcodes are misread now and then)."""
MRCLAM_CONFIG = EkfConfig(
    slip_per_metre=0.05, turn_slip_per_metre=0.05, turn_slip_per_radian=0.07, turn_bias_per_metre=0.05
)
MRCLAM_WAY = 0.92
"""MRCLAM's odometry overstates the way by 7 to 11 %."""
MRCLAM_NOISE = (0.3, 0.08, 0.05)
"""Range deviation (m, and for each metre) and bearing deviation (rad): three times the scatter, because the errors are
biased and last over many sightings.  Chosen on the set itself."""
DLR_CONFIG = EkfConfig(slip_per_metre=0.02, turn_slip_per_metre=0.04, turn_slip_per_radian=0.03)
"""The log's own covariances: 4.5 mm and 17 mrad for a step of 0.19 m."""


@dataclass(frozen=True)
class LogStep:
    """Odometry since the last step, then what was seen: sightings and their ids (-1: unknown)."""

    odometry: SE2
    sightings: tuple[LandmarkSighting, ...]
    ids: tuple[int, ...]
    stamp_s: float = 0.0


def fit(estimate: Array, truth: Array) -> SE2:
    """Return the rigid motion that brings points (n x 2) nearest to others (Umeyama, without scale)."""
    a, b = estimate - estimate.mean(axis=0), truth - truth.mean(axis=0)
    theta = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    turned = SE2(0.0, 0.0, theta).apply_all(estimate.mean(axis=0)[None])[0]
    shift = truth.mean(axis=0) - turned
    return SE2(float(shift[0]), float(shift[1]), theta)


def rmse(estimate: Array, truth: Array) -> float:
    """Return the root mean square distance (m) after a rigid fit."""
    moved = fit(estimate, truth).apply_all(estimate)
    return float(np.sqrt(((moved - truth) ** 2).sum(axis=1).mean()))


def flat_with_ids(steps: list[LogStep], config: EkfConfig) -> tuple[Array, dict[int, Array]]:
    """Run one filter that is told the ids; return the online path (n x 3) and the landmarks by id."""
    ekf = LandmarkFilter(SE2(), 0.0, config.turn_bias_per_metre**2, config)
    index: dict[int, int] = {}
    path = []
    for step in steps:
        ekf.predict(step.odometry)
        readings = {i: s for i, s in zip(step.ids, step.sightings, strict=True) if i >= 0}
        rows = np.array(list(readings.values())).reshape(-1, 4)
        known = np.array([i in index for i in readings], dtype=bool)
        landmarks = np.array([index[i] for i in readings if i in index], dtype=np.intp)
        expected, noise = ekf.expect(landmarks), rows[known, 2:] ** 2
        innovation = rows[known, :2] - expected.sightings
        innovation[:, 1] = wrap_all(innovation[:, 1])
        spread = expected.spread + noise[:, :, None] * np.eye(2)
        chi = np.einsum("ki,kij,kj->k", innovation, np.linalg.inv(spread), innovation)
        read = np.flatnonzero(chi < MISREAD_GATE)
        ekf.correct(expected, read, rows[known, :2][read], noise[read])
        fresh = rows[~known]
        if len(fresh):
            index |= {i: len(index) + k for k, i in enumerate(i for i in readings if i not in index)}
            ekf.augment(fresh[:, :2], fresh[:, 2:] ** 2)
        path.append(ekf.mean[:3].copy())
    return np.array(path), {i: ekf.landmarks[k].copy() for i, k in index.items()}


def mrclam_steps(folder: Path, robot: int) -> list[LogStep]:
    """Read one robot's log of MRCLAM; only the fifteen landmarks are kept."""
    subject = {int(code): int(s) for s, code in np.loadtxt(folder / "Barcodes.dat")}
    odometry = np.loadtxt(folder / f"Robot{robot}_Odometry.dat")
    seen = np.loadtxt(folder / f"Robot{robot}_Measurement.dat")
    times, starts = np.unique(seen[:, 0], return_index=True)
    moves = _integrated(odometry, times)
    base, slope, bearing_std = MRCLAM_NOISE
    steps = []
    for when, rows, move in zip(times, np.split(seen, starts[1:]), moves, strict=True):
        found = [(subject.get(int(code), 0), r, b) for _, code, r, b in rows]
        kept = [(i, LandmarkSighting(r, b, base + slope * r, bearing_std)) for i, r, b in found if i > 5]
        steps.append(LogStep(move, tuple(s for _, s in kept), tuple(i for i, _ in kept), float(when)))
    return steps


def _integrated(odometry: Array, times: Array) -> Iterator[SE2]:
    """Yield the motion between successive ``times`` of a log of time, forward m/s and turn rad/s, held in between."""
    ends = np.append(odometry[1:, 0], math.inf)
    row, now = 0, float(odometry[0, 0])
    for until in times.tolist():
        move = SE2()
        while now < until:
            later = min(until, float(ends[row]))
            span, forward, turn = later - now, MRCLAM_WAY * float(odometry[row, 1]), float(odometry[row, 2])
            half = 0.5 * turn * span
            move = move @ SE2(forward * span * math.cos(half), forward * span * math.sin(half), turn * span)
            now, row = later, row + (later == ends[row])
        yield move


def mrclam(folder: Path) -> None:
    """Print the figures of each robot of MRCLAM 6 with ids."""
    truth = {int(s): np.array([x, y]) for s, x, y, _, _ in np.loadtxt(folder / "Landmark_Groundtruth.dat")}
    ates, errors = [], []
    for robot in range(1, 6):
        steps = mrclam_steps(folder, robot)
        began = time.process_time()
        path, landmarks = flat_with_ids(steps, MRCLAM_CONFIG)
        spent = time.process_time() - began
        vicon = np.loadtxt(folder / f"Robot{robot}_Groundtruth.dat")
        stamps = np.array([step.stamp_s for step in steps])
        inside = (stamps > vicon[0, 0]) & (stamps < vicon[-1, 0])
        true = np.column_stack([np.interp(stamps, vicon[:, 0], vicon[:, k]) for k in (1, 2)])
        ates.append(rmse(path[inside, :2], true[inside]))
        errors.append(rmse(np.array(list(landmarks.values())), np.array([truth[i] for i in landmarks])))
        print(f"MRCLAM 6 robot {robot}, ids: ATE {ates[-1]:.3f} m, landmarks {errors[-1]:.3f} m, {spent:.1f} s")
    print(f"MRCLAM 6 mean of 5, ids: ATE {np.mean(ates):.3f} m, landmarks {np.mean(errors):.3f} m")


def dlr_steps(path: Path) -> list[LogStep]:
    """Read the DLR log; its robot looks along -Y, so base_link's x is -Y and its y is X."""
    steps: list[LogStep] = []
    moved = SE2()
    sightings: list[LandmarkSighting] = []
    ids: list[int] = []
    for line in path.read_text(errors="replace").splitlines():
        word, *rest = line.split() or [""]
        if word == "STEP":
            steps.append(LogStep(moved, tuple(sightings), tuple(ids)))
            x, y, turn = map(float, rest[1:4])
            moved, sightings, ids = SE2(-y, x, turn), [], []
        elif word == "LANDMARK_C":
            x, y, _, cxx, cxy, cyy = map(float, rest[:6])
            sightings.append(_polar(-y, x, np.array([[cyy, -cxy], [-cxy, cxx]])))
            ids.append(int(rest[6]) if len(rest) > 6 else -1)
    return [*steps[1:], LogStep(moved, tuple(sightings), tuple(ids))]


def _polar(x: float, y: float, covariance: Array) -> LandmarkSighting:
    """Return a Cartesian sighting as range and bearing with the deviations along and across the line of sight."""
    distance = math.hypot(x, y)
    along = np.array([x, y]) / distance
    across = np.array([-along[1], along[0]])
    spread = math.sqrt(along @ covariance @ along), math.sqrt(across @ covariance @ across) / distance
    return LandmarkSighting(distance, math.atan2(y, x), *spread)


def batch(steps: list[LogStep], path: Array, landmarks: dict[int, Array]) -> tuple[Array, dict[int, Array]]:
    """Return the path (n x 2) and landmarks that are most likely given all ids, from a start near enough."""
    graph, start = gtsam.NonlinearFactorGraph(), gtsam.Values()
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)))
    start.insert(0, gtsam.Pose2())
    for i, landmark in landmarks.items():
        start.insert(gtsam.symbol("l", i), landmark)
    for k, step in enumerate(steps, start=1):
        deviations = np.sqrt(np.diag(slip_noise(step.odometry, DLR_CONFIG))[:3]) + 1e-3
        noise = gtsam.noiseModel.Diagonal.Sigmas(deviations)
        graph.add(gtsam.BetweenFactorPose2(k - 1, k, gtsam.Pose2(*step.odometry), noise))
        start.insert(k, gtsam.Pose2(*path[k - 1]))
        for i, seen in zip(step.ids, step.sightings, strict=True):
            if i in landmarks:
                sigma = gtsam.noiseModel.Diagonal.Sigmas(np.array([seen.bearing_std, seen.range_std_m]))
                robust = gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.Huber.Create(2.0), sigma)
                key = gtsam.symbol("l", i)
                graph.add(gtsam.BearingRangeFactor2D(k, key, gtsam.Rot2(seen.bearing), seen.range_m, robust))
    best = gtsam.LevenbergMarquardtOptimizer(graph, start).optimize()
    poses = [best.atPose2(k) for k in range(1, len(steps) + 1)]
    points = {i: np.array(best.atPoint2(gtsam.symbol("l", i))) for i in landmarks}
    return np.array([[pose.x(), pose.y()] for pose in poses]), points


def without_ids(steps: list[LogStep]) -> tuple[Array, int]:
    """Run one filter that is told no ids; return the online path (n x 2) and the number of its landmarks."""
    traversal = Traversal(0, SE2(), SE2(), 0.0, DLR_CONFIG.turn_bias_per_metre**2, DLR_CONFIG)
    odom, path = SE2(), []
    for step in steps:
        odom = odom @ step.odometry
        traversal.advance(odom)
        traversal.look(LandmarkView(0, SIGHT_M, step.sightings))
        path.append(traversal.filter.mean[:2].copy())
    return np.array(path), len(traversal.filter.landmarks)


def pieces(steps: list[LogStep], length_m: float) -> Iterator[slice]:
    """Yield stretches of a log of about a given length driven."""
    driven = np.cumsum([math.hypot(step.odometry.x, step.odometry.y) for step in steps])
    for k in range(math.ceil(driven[-1] / length_m)):
        yield slice(*np.searchsorted(driven, (k * length_m, (k + 1) * length_m)).tolist())


def distinct(steps: list[LogStep]) -> int:
    """Return how many different discs were seen."""
    return len({i for step in steps for i in step.ids if i >= 0})


def dlr(path: Path) -> None:
    """Print the figures of the DLR log."""
    steps = dlr_steps(path)
    began = time.process_time()
    online, landmarks = flat_with_ids(steps, DLR_CONFIG)
    spent = time.process_time() - began
    true, points = batch(steps, online, landmarks)
    error = rmse(np.array(list(landmarks.values())), np.array([points[i] for i in landmarks]))
    print(f"DLR, ids, flat: ATE {rmse(online[:, :2], true):.2f} m, landmarks {error:.2f} m, {spent:.1f} s")
    began = time.process_time()
    found, count = without_ids(steps)
    spent = time.process_time() - began
    print(f"DLR, no ids, flat: ATE {rmse(found, true):.2f} m, {count - distinct(steps):+d} landmarks, {spent:.1f} s")
    for length_m in (20.0, 40.0, 80.0):
        errors, extra = [], []
        for piece in pieces(steps, length_m):
            found, count = without_ids(steps[piece])
            errors.append(rmse(found, true[piece]))
            extra.append(count - distinct(steps[piece]))
        print(
            f"DLR, no ids, a new map every {length_m:.0f} m: ATE in the map {np.mean(errors):.3f} m "
            f"(worst of {len(errors)}: {max(errors):.3f}), {np.mean(extra):+.1f} landmarks a map"
        )


def main() -> None:
    """Run what was asked for; says so where the logs are not there."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sets", nargs="*", metavar="mrclam|dlr", help="which logs; all without")
    parser.add_argument("--data", type=Path, default=DATA)
    options = parser.parse_args()
    sets = options.sets or ["mrclam", "dlr"]
    if unknown := set(sets) - {"mrclam", "dlr"}:
        parser.error(f"no such logs: {', '.join(sorted(unknown))}")
    if not options.data.is_dir():
        sys.exit(f"no logs in {options.data}: give --data FOLDER")
    if "mrclam" in sets:
        mrclam(options.data / "mrclam6")
    if "dlr" in sets:
        dlr(options.data / "dlr" / "map.circles")


if __name__ == "__main__":
    main()
