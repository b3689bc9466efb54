"""Join local maps with known landmark ids into one: the least-squares answer over all of them.

Every local map begins where the one before it ended, as in Huang, Wang and Dissanayake, "Sparse local submap joining
filter", IEEE Transactions on Robotics 2008.  Each is one factor with its full covariance, so that nothing is lost by
joining, and the start is their chain: a start from afar ends in a wrong minimum.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import gtsam
import numpy as np

from hslam_atlas.errors import AtlasError
from hslam_atlas.local_map_factor import LocalMap, local_map_factor
from hslam_types.se2 import SE2, Array

_ANCHOR_STD = 1e-6
"""Of the first frame (m, rad): it is where all else is told from."""


class JoiningError(AtlasError):
    """Local maps that cannot be joined; the text says which and why."""


@dataclass(frozen=True, slots=True, eq=False)
class Submap:
    """A local map whose landmarks have names."""

    local: LocalMap
    ids: tuple[int, ...]
    """Of its points, in their order."""


@dataclass(frozen=True, slots=True, eq=False)
class JoinedMap:
    """All local maps as one, in the frame of the first (m, rad)."""

    frames: tuple[SE2, ...]
    """Where each map began, and where the last one ended."""
    landmarks: Mapping[int, tuple[float, float]]
    """By id."""


def join(submaps: Sequence[Submap]) -> JoinedMap:
    """Return the joined map; raises JoiningError where a map is none (ids, shapes, a covariance without inverse)."""
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    factors.addPriorPose2(_frame(0), gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, _ANCHOR_STD))
    values.insert(_frame(0), gtsam.Pose2())
    frame, known = SE2(), set[int]()
    for index, submap in enumerate(submaps):
        _check(index, submap)
        keys = [_landmark(name) for name in submap.ids]
        factors.add(local_map_factor(_frame(index), _frame(index + 1), keys, submap.local))
        for name, place in zip(submap.ids, frame.apply_all(submap.local.points), strict=True):
            if name not in known:
                values.insert(_landmark(name), place)
        known.update(submap.ids)
        frame = frame @ submap.local.end
        values.insert(_frame(index + 1), gtsam.Pose2(*frame))
    solved = gtsam.LevenbergMarquardtOptimizer(factors, values, gtsam.LevenbergMarquardtParams()).optimize()
    poses = [solved.atPose2(_frame(index)) for index in range(len(submaps) + 1)]
    places = {name: solved.atPoint2(_landmark(name)) for name in sorted(known)}
    return JoinedMap(
        tuple(SE2(pose.x(), pose.y(), pose.theta()) for pose in poses),
        {name: (float(x), float(y)) for name, (x, y) in places.items()},
    )


def _check(index: int, submap: Submap) -> None:
    size = 3 + 2 * len(submap.ids)
    if len(set(submap.ids)) != len(submap.ids) or any(name < 0 for name in submap.ids):
        raise JoiningError(f"local map {index}: ids must be whole numbers from 0, each once")
    if submap.local.points.shape != (len(submap.ids), 2) or submap.local.covariance.shape != (size, size):
        raise JoiningError(
            f"local map {index}: {len(submap.ids)} ids need as many points and a {size} x {size} covariance"
        )
    if not _is_positive_definite(submap.local.covariance):
        raise JoiningError(f"local map {index}: its covariance is not positive definite")


def _is_positive_definite(covariance: Array) -> bool:
    try:
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        return False
    return bool(np.allclose(covariance, covariance.T, rtol=1e-6, atol=1e-9))


def _frame(index: int) -> int:
    return gtsam.symbol("x", index)


def _landmark(name: int) -> int:
    return gtsam.symbol("l", name)
