"""Records the sample bags anew: `make setup`, then `python bags/samples/record_samples.py` in the environment it made.

Needed when a change of sensors, messages or navigation makes the recorded runs out of date; a change of the EKF or the
atlas alone does not, as the bags hold what those hear.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from hslam_bags.bag import Bag
from hslam_bags.repair import copy
from hslam_bags.topic_choice import TopicChoice

HERE = Path(__file__).parent
WHOLE = TopicChoice()
HEARD_BY_THE_ATLAS = TopicChoice(("odom", "landmarks", "gvg/events", "atlas/atlas"))
SAMPLES = {
    "small_world_1": ("small_world", 1, WHOLE),
    "small_world_2_heard": ("small_world", 2, HEARD_BY_THE_ATLAS),
}
"""Folder: world, seed and topics."""


def record(name: str, world: str, seed: int, choice: TopicChoice) -> None:
    """Explore a world and keep the chosen topics of its bag."""
    with tempfile.TemporaryDirectory() as scratch:
        run = Path(scratch) / "run"
        command = [".venv/bin/hslam", "explore", world, "--seed", str(seed), "--out", str(run), "--in-process"]
        subprocess.run(command, check=True, cwd=HERE.parents[1])
        shutil.rmtree(HERE / name, ignore_errors=True)
        with Bag(run / "bag") as bag:
            copy(bag, HERE / name, choice)


def main() -> None:
    """Record every sample."""
    for name, (world, seed, choice) in SAMPLES.items():
        record(name, world, seed, choice)


if __name__ == "__main__":
    main()
