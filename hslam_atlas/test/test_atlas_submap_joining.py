"""Local maps with known ids are joined as well as all their measurements allow; what is no map is refused."""

import math
from dataclasses import replace

import gtsam
import numpy as np
import pytest

from hslam_atlas.local_map_factor import LocalMap, local_map_factor
from hslam_atlas.submap_joining import JoiningError, Submap, join
from hslam_types.se2 import SE2, Array, wrap

STEP = SE2(6.0, 0.5, 2.0 * math.pi / 12.0)
SPREAD = np.array([0.05, 0.05, 0.02])


def circle(seed: int, noise: float = 1.0, rounds: int = 2) -> tuple[list[Submap], list[SE2], dict[int, Array]]:
    """Return maps along a circle driven more than once, with the true frames and landmarks."""
    rng = np.random.default_rng(seed)
    frames = [SE2()]
    for _ in range(12 * rounds):
        frames.append(frames[-1] @ STEP)
    landmarks = {n: frames[n % 12].apply_all(rng.uniform(-4.0, 8.0, (1, 2)))[0] for n in range(40)}
    submaps = []
    for frame in frames[:-1]:
        in_map = {n: frame.inverse().apply(*place.tolist()) for n, place in landmarks.items()}
        ids = tuple(n for n, place in in_map.items() if math.hypot(*place) < 8.0)
        size = 3 + 2 * len(ids)
        root = np.tril(rng.normal(0.0, 0.01, (size, size))) + np.diag([*SPREAD, *[0.05] * (size - 3)])
        error = noise * root @ rng.normal(size=size)
        end = SE2(*(np.array(STEP) + error[:3]).tolist())
        points = np.array([in_map[n] for n in ids]) + error[3:].reshape(-1, 2)
        submaps.append(Submap(LocalMap(end, points, root @ root.T), ids))
    return submaps, frames, landmarks


def test_without_noise_it_is_the_truth() -> None:
    submaps, frames, landmarks = circle(1, noise=0.0)
    joined = join(submaps)
    assert np.abs(np.array([joined.landmarks[n] for n in landmarks]) - np.array(list(landmarks.values()))).max() < 1e-5
    for found, true in zip(joined.frames, frames, strict=True):
        assert math.dist(found[:2], true[:2]) < 1e-5
        assert abs(wrap(found.theta - true.theta)) < 1e-6


def test_errors_are_those_of_one_map_and_not_those_of_the_whole_way() -> None:
    joined_m, chained_m = [], []
    for seed in range(6):
        submaps, frames, landmarks = circle(seed)
        joined = join(submaps)
        chain = SE2()
        for submap in submaps:
            chain = chain @ submap.local.end
        joined_m.append(math.dist(joined.frames[-1][:2], frames[-1][:2]))
        chained_m.append(math.dist(chain[:2], frames[-1][:2]))
        assert max(math.dist(joined.landmarks[n], place) for n, place in landmarks.items()) < 0.5
    assert np.mean(joined_m) < 0.3 * np.mean(chained_m)


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_the_error(seed: int) -> None:
    """Against differences, by gtsam's own retraction: the keys of the poses are 0 and 1, of the points 2 and 3."""
    rng = np.random.default_rng(seed)
    local = LocalMap(SE2(3.0, 1.0, 0.7), rng.normal(size=(2, 2)), np.eye(7))
    factor = local_map_factor(0, 1, (2, 3), local)
    values = gtsam.Values()
    for key in (0, 1):
        values.insert(key, gtsam.Pose2(*rng.normal(size=3).tolist()))
    for key in (2, 3):
        values.insert(key, rng.normal(size=2))
    matrix, _ = factor.linearize(values).jacobian()
    step, columns = 1e-6, []
    for key, size in ((0, 3), (1, 3), (2, 2), (3, 2)):
        for axis in range(size):
            ends = []
            for sign in (1.0, -1.0):
                delta = gtsam.VectorValues()
                for other, width in ((0, 3), (1, 3), (2, 2), (3, 2)):
                    moved = np.zeros(width)
                    moved[axis if other == key else 0] = sign * step if other == key else 0.0
                    delta.insert(other, moved)
                ends.append(factor.unwhitenedError(values.retract(delta)))
            columns.append((ends[0] - ends[1]) / (2.0 * step))
    assert matrix == pytest.approx(np.column_stack(columns), abs=1e-6)


def test_points_of_one_map_alone_follow_those_that_are_known_better() -> None:
    # Two points with one error between them: when the first proves to lie 0.2 m to the left, so does the second.
    spread = np.eye(7) * 1e-6
    spread[4, 4] = spread[6, 6] = spread[4, 6] = spread[6, 4] = 0.04
    spread[4, 4] += 1e-6
    spread[6, 6] += 1e-6
    local = LocalMap(SE2(5.0, 0.0, 0.0), np.array([[1.0, 0.0], [2.0, 0.0]]), spread)
    moved = local.conditioned(local.end, [0], np.array([[1.0, 0.2]]))
    assert moved == pytest.approx(np.array([[1.0, 0.2], [2.0, 0.2]]), abs=1e-3)


@pytest.mark.parametrize(
    ("ids", "covariance", "what"),
    [
        ((1, 1), np.eye(7), "each once"),
        ((1, -2), np.eye(7), "whole numbers"),
        ((1, 2), np.eye(5), "7 x 7"),
        ((1, 2, 3), np.eye(9), "as many points"),
        ((1, 2), np.diag([1.0] * 6 + [-1.0]), "positive definite"),
    ],
)
def test_what_is_no_map_is_refused_by_number(ids: tuple[int, ...], covariance: Array, what: str) -> None:
    good = Submap(LocalMap(SE2(1.0, 0.0, 0.0), np.zeros((2, 2)), np.eye(7)), (1, 2))
    bad = Submap(replace(good.local, covariance=covariance), ids)
    with pytest.raises(JoiningError, match=rf"local map 1: .*{what}"):
        join([good, bad])
