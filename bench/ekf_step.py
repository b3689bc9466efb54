"""What one step of the EKF level costs: `python bench/ekf_step.py [--repeat N]`.

Drives along straight corridors with a look every third step. CPU time of this process is counted, which a busy
machine does not inflate; the least of several repeats is told.
"""

import argparse
import time

import numpy as np

from hslam_ekf.server import EkfServer
from hslam_ekf.synthetic_drive import DriveErrors, corridor_landmarks, drive


def measure(length_m: float, range_max_m: float, repeat: int) -> str:
    """Return a line of figures of one drive."""
    rng = np.random.default_rng(0)
    path = np.array([[0.0, 0.0], [length_m, 0.0]])
    landmarks = corridor_landmarks(path, rng)
    steps = drive(path, landmarks, DriveErrors(range_max_m=range_max_m), rng)
    spent = []
    for _ in range(repeat):
        server = EkfServer()
        began = time.process_time()
        for step in steps:
            server.step(step.odom, step.view, step.events)
        spent.append(time.process_time() - began)
    looks = [len(step.view.sightings) for step in steps if step.view is not None]
    return (
        f"{len(landmarks):4d} landmarks, {np.mean(looks):4.1f} sightings a look, {len(steps)} steps: "
        f"{1e3 * min(spent) / len(steps):.3f} ms a step"
    )


def main() -> None:
    """Print one line a drive."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3)
    repeat = parser.parse_args().repeat
    for length_m, range_max_m in ((30.0, 2.6), (30.0, 6.0), (75.0, 2.6), (75.0, 6.0)):
        print(measure(length_m, range_max_m, repeat))


if __name__ == "__main__":
    main()
