"""A drive along corridors with known truth, for measuring the filter: consistency, clutter, cost.

Not a simulator of the robot: the path is given, walls only hide landmarks, and the errors are exactly those
the filter's model speaks of, so that NEES and NIS have their textbook distribution if the filter is right.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import LandmarkSighting, LandmarkView, OdometrySample

STEP_NS = 120_000_000
"""One cycle of the base."""


@dataclass(frozen=True)
class DriveErrors:
    """The errors of base and sensor on a drive (units as in `EkfConfig`)."""

    slip_per_metre: float = 0.02
    turn_slip_per_metre: float = math.radians(0.7)
    turn_slip_per_radian: float = 0.03
    turn_bias_per_metre: float = math.radians(1.0)
    range_std_m: float = 0.05
    bearing_std: float = math.radians(1.0)
    range_max_m: float = 6.0
    missed: float = 0.1
    clutter: float = 0.01
    """False sightings for each true one."""
    homing_m: float = 0.02
    look_every: int = 3


@dataclass(frozen=True, eq=False)
class DriveStep:
    """One cycle: what the EKF level hears, and the truth."""

    odom: OdometrySample
    view: LandmarkView | None
    events: tuple[GvgEvent, ...]
    base_in_map: SE2


def corridor_landmarks(path: Array, rng: np.random.Generator, *, width: float = 2.4, spacing: float = 1.0) -> Array:
    """Return landmarks (n x 2, m) on both walls of a ``path`` of corner points (k x 2), about one each ``spacing``."""
    found: list[Array] = []
    for start, end in pairwise(path):
        along = (end - start) / np.linalg.norm(end - start)
        across = np.array([-along[1], along[0]])
        for side in (-0.5 * width, 0.5 * width):
            count = round(float(np.linalg.norm(end - start)) / spacing)
            where = (np.arange(count) + rng.uniform(0.1, 0.6, count)) * spacing
            found.append(start + where[:, None] * along + side * across)
    return np.concatenate(found)


def drive(path: Array, landmarks: Array, errors: DriveErrors, rng: np.random.Generator) -> list[DriveStep]:
    """Drive along a ``path`` (k x 2, m): DEPARTURE, ARRIVAL at its end, a turn on the spot, DEPARTURE."""
    poses = _poses(path)
    steps: list[DriveStep] = []
    encoder = SE2(*rng.uniform(-3.0, 3.0, 3).tolist())
    arrival = len(poses) - 1
    turned = _turn(poses[-1], math.pi)
    for i, base in enumerate([*poses, *turned]):
        if i:
            encoder = encoder @ _encoder_step(steps[-1].base_in_map.to(base), errors, rng)
        stamp = i * STEP_NS
        view = _look(stamp, base, landmarks, errors, rng) if i % errors.look_every == 1 else None
        events: tuple[GvgEvent, ...] = ()
        if i in (0, arrival, arrival + len(turned)):
            node = path[0] if i == 0 else path[-1] + rng.normal(0.0, errors.homing_m, 2) * (i == arrival)
            events = (_event(len([s for s in steps if s.events]), stamp, base, encoder, node),)
        steps.append(DriveStep(OdometrySample(stamp, encoder), view, events, base))
    return steps


def _poses(path: Array) -> list[SE2]:
    """Return true poses, 5 cm or 4 degrees apart, along the path, beginning some centimetres off its start."""
    heading = math.atan2(*(path[1] - path[0])[::-1].tolist())
    poses = [SE2(float(path[0, 0]), float(path[0, 1]), heading) @ SE2(0.03, -0.02, 0.05)]
    for target in path[1:]:
        dx, dy = (target - np.array(poses[-1][:2])).tolist()
        poses += _turn(poses[-1], wrap(math.atan2(dy, dx) - poses[-1].theta))
        count = math.ceil(math.hypot(dx, dy) / 0.05)
        poses += [poses[-1] @ SE2((k + 1) * math.hypot(dx, dy) / count, 0.0, 0.0) for k in range(count)]
    return poses


def _turn(pose: SE2, angle: float) -> list[SE2]:
    """Return the poses of a turn on the spot by ``angle`` (rad)."""
    count = math.ceil(abs(angle) / 0.07)
    return [pose @ SE2(0.0, 0.0, (k + 1) * angle / count) for k in range(count)]


def _encoder_step(true: SE2, errors: DriveErrors, rng: np.random.Generator) -> SE2:
    """Return what the odometry tells of a true step."""
    way = math.hypot(true.x, true.y)
    shift = rng.normal(0.0, errors.slip_per_metre * math.sqrt(way), 2).tolist()
    turn = math.hypot(errors.turn_slip_per_metre * math.sqrt(way), errors.turn_slip_per_radian * abs(true.theta) ** 0.5)
    bias = errors.turn_bias_per_metre * true.x
    return SE2(true.x + shift[0], true.y + shift[1], true.theta + bias + float(rng.normal(0.0, turn)))


def _look(stamp_ns: int, base: SE2, landmarks: Array, errors: DriveErrors, rng: np.random.Generator) -> LandmarkView:
    """Return a look at the landmarks in range, with missed and false ones."""
    local = base.inverse().apply_all(landmarks)
    distance = np.hypot(local[:, 0], local[:, 1])
    seen = local[(distance < errors.range_max_m) & (rng.random(len(landmarks)) > errors.missed)]
    true = np.column_stack((np.hypot(seen[:, 0], seen[:, 1]), np.arctan2(seen[:, 1], seen[:, 0])))
    true += rng.standard_normal(true.shape) * (errors.range_std_m, errors.bearing_std)
    count = int(rng.poisson(errors.clutter * len(true)))
    false = np.column_stack((errors.range_max_m * np.sqrt(rng.random(count)), rng.uniform(-math.pi, math.pi, count)))
    sightings = tuple(
        LandmarkSighting(r, wrap(b), errors.range_std_m, errors.bearing_std)
        for r, b in np.concatenate((true, false)).tolist()
    )
    return LandmarkView(stamp_ns, errors.range_max_m, sightings)


def _event(sequence: int, stamp_ns: int, base: SE2, encoder: SE2, node: Array) -> GvgEvent:
    """Announce a node at a true position with one branch, the way the robot faces."""
    x, y = (encoder @ base.inverse()).apply(*node.tolist())
    view = NodeView(NodeKind.MEET_POINT, x, y, 1.2, (encoder.theta,))
    kind = EventKind.ARRIVAL if sequence == 1 else EventKind.DEPARTURE
    return GvgEvent(sequence, stamp_ns, kind, view, 0)
