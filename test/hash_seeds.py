"""The same work in processes whose texts hash differently: what depends on the order of a set comes out otherwise."""

import os
import subprocess
import sys
from collections.abc import Callable

SEEDS = ("1", "2")


def under_two_hash_seeds(work: Callable[[], str]) -> tuple[str, str]:
    """Return what ``work``, a function at the top of its module, returns in two new processes."""
    program = f"import sys; from {work.__module__} import {work.__name__} as work; sys.stdout.write(work())"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", program],
            stdout=subprocess.PIPE,
            text=True,
            env=environment | {"PYTHONHASHSEED": seed},
        )
        for seed in SEEDS
    ]
    first, second = (process.communicate()[0] for process in running)
    assert [process.returncode for process in running] == [0, 0]
    return first, second
