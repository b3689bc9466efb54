"""Keeps two runs on one machine, and the rest of the network, from hearing each other."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hslam_bringup.errors import RunError

_DOMAINS = range(20, 100)
"""ROS domain ids to choose from; 0 to 101 are safe on every platform, the low ones are people's own."""


@contextmanager
def private_domain() -> Iterator[dict[str, str]]:
    """Reserve a ROS domain for a run and yield the environment its processes need; raises RunError if none is free.

    The reservation is a lock on a file, which the system releases however the run ends.
    """
    for domain in _DOMAINS:
        path = Path(tempfile.gettempdir()) / f"hslam_domain_{domain}.lock"
        try:
            descriptor = os.open(path, os.O_CREAT | os.O_RDWR, 0o666)
        except PermissionError:
            continue
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(descriptor)
            continue
        try:
            yield {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        finally:
            os.close(descriptor)
        return
    raise RunError(f"all ROS domains from {_DOMAINS.start} to {_DOMAINS.stop - 1} are in use by other runs")
