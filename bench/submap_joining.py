"""Joining local maps of others, ids known: `python bench/submap_joining.py [--data FOLDER] [--535] [--8240] [--DLR]`.

535 and 8240 are simulations with the truth (Huang, Wang, UTS), DLR has none.  Landmarks are laid on the truth by one
rigid motion; beside them what chaining the maps alone gives.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from hslam_atlas.local_map_factor import LocalMap
from hslam_atlas.submap_joining import JoinedMap, Submap, join
from hslam_report.landmark_score import rigid_fit
from hslam_types.se2 import SE2, Array

DATA = Path(__file__).parents[2] / "shared" / "landmark_data" / "submaps"
SETS = {"535": "535_data_5_local_maps", "8240": "8240_data_50_local_maps", "DLR": "DLR_200_local_maps"}


def read_submaps(folder: Path) -> list[Submap]:
    """Read ``localmap_<i>.mat``: rows (id, value), the end pose's three first, and the covariance of the values."""
    submaps = []
    for index in range(1, 1 + len(list(folder.glob("localmap_*.mat")))):
        stored = loadmat(folder / f"localmap_{index}.mat")
        rows, covariance = stored["localmap_st"], np.array(stored["localmap_P"], dtype=float)
        values = rows[:, 1].astype(float)
        local = LocalMap(SE2(*values[:3].tolist()), values[3:].reshape(-1, 2), 0.5 * (covariance + covariance.T))
        submaps.append(Submap(local, tuple(int(name) for name in rows[3::2, 0])))
    return submaps


def chained(submaps: list[Submap]) -> JoinedMap:
    """Return the maps laid end to end, a landmark where the first map to see it has it."""
    frames, landmarks = [SE2()], dict[int, tuple[float, float]]()
    for submap in submaps:
        for name, point in zip(submap.ids, frames[-1].apply_all(submap.local.points).tolist(), strict=True):
            landmarks.setdefault(name, (point[0], point[1]))
        frames.append(frames[-1] @ submap.local.end)
    return JoinedMap(tuple(frames), landmarks)


def landmark_rmse_m(joined: JoinedMap, truth: dict[int, tuple[float, float]]) -> float:
    """Return the error of the landmarks after a rigid fit (m)."""
    names = sorted(joined.landmarks.keys() & truth.keys())
    found, true = (np.array([places[name] for name in names]) for places in (joined.landmarks, truth))
    off: Array = rigid_fit(found, true).apply_all(found) - true
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def true_landmarks(folder: Path) -> dict[int, tuple[float, float]] | None:
    """Return the true places by id, None where the set has none."""
    path = folder / "store_beaconsTrue.mat"
    if not path.exists():
        return None
    return {int(name): (float(x), float(y)) for name, x, y in loadmat(path)["store_beaconsTrue"]}


def main() -> None:
    """Print one line a set."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in SETS:
        parser.add_argument(f"--{name}", dest="sets", action="append_const", const=name, help="only this set, or these")
    parser.add_argument("--data", type=Path, default=DATA)
    arguments = parser.parse_args()
    if not arguments.data.is_dir():
        sys.exit(f"{arguments.data}: no such folder; --data names where the sub-map sets are")
    for name in arguments.sets or SETS:
        folder = arguments.data / SETS[name]
        submaps = read_submaps(folder)
        start = time.perf_counter()
        joined = join(submaps)
        spent = time.perf_counter() - start
        truth = true_landmarks(folder)
        figures = (
            f"landmark RMSE {landmark_rmse_m(joined, truth):.3f} m, "
            f"chained {landmark_rmse_m(chained(submaps), truth):.3f} m"
            if truth
            else "no truth"
        )
        sys.stdout.write(f"{name}: {len(submaps)} maps, {len(joined.landmarks)} landmarks, {spent:.2f} s, {figures}\n")


if __name__ == "__main__":
    main()
