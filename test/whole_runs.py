"""Starting `hslam` as a person does, and looking at what it left."""

import os
import signal
import sqlite3
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

from hslam_bringup.fleet import executable
from hslam_bringup.linear_algebra import ON_ONE_THREAD

PATIENCE_S = 600.0

signal.signal(signal.SIGINT, signal.default_int_handler)
"""Started in the background of a shell, these tests ignore Ctrl-C, and so would every command that they start."""


def hslam(*arguments: str, hash_seed: str = "random") -> subprocess.Popen[str]:
    """Start the command, in an environment that has not chosen how many threads it uses."""
    command = [str(executable("hslam_bringup", "hslam")), *arguments]
    environment = {name: value for name, value in os.environ.items() if name not in ON_ONE_THREAD}
    environment |= {"COLUMNS": "200", "PYTHONHASHSEED": hash_seed}
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def outcome(run: subprocess.Popen[str], within_s: float = PATIENCE_S) -> tuple[int, str, str]:
    """Return exit status, stdout and stderr of a command that has to end in time."""
    try:
        out, err = run.communicate(timeout=within_s)
    except subprocess.TimeoutExpired:
        run.send_signal(signal.SIGKILL)
        raise
    return run.returncode, out, err


def wait_until(holds: Callable[[], bool], within_s: float = PATIENCE_S) -> None:
    """Wait for a condition on the outside world; fails when it does not come to hold."""
    deadline = time.monotonic() + within_s
    pause = threading.Event()
    while not holds():
        assert time.monotonic() < deadline, "the condition did not come to hold in time"
        pause.wait(0.05)


def atlas_dump(path: Path) -> list[str]:
    """Return an atlas file's content as SQL."""
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as atlas:
        return list(atlas.iterdump())
