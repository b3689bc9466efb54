"""How many threads linear algebra may use: one, in every process of a run.

More are slower on small matrices, and change the order of sums, and with it the last bits of a result.
"""

import os

ON_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
"""What the libraries look for when they are loaded."""


def hold_to_one_thread() -> None:
    """Say so in this process's environment where the user has not chosen; numpy must not be loaded yet."""
    for name, value in ON_ONE_THREAD.items():
        os.environ.setdefault(name, value)
