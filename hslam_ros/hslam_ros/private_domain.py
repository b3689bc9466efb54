"""Keeps two runs on one machine, and the rest of the network, from hearing each other."""

import dataclasses
import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hslam_types.errors import HslamError

_DOMAINS = range(20, 100)
"""ROS domain ids to choose from; 0 to 101 are safe on every platform, the low ones are people's own."""


class DomainError(HslamError):
    """No ROS domain is free."""


@dataclasses.dataclass(frozen=True)
class PrivateDomain:
    """A ROS domain that no other run uses."""

    number: int
    reservation: int
    """File descriptor of the lock; processes that inherit it keep the domain reserved as long as they live."""

    @property
    def environment(self) -> dict[str, str]:
        """What the processes of the run need in their environment."""
        return {"ROS_DOMAIN_ID": str(self.number), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@contextmanager
def private_domain() -> Iterator[PrivateDomain]:
    """Reserve a ROS domain for a run; raises DomainError if none is free.

    The reservation is a lock on a file, which the system releases when the run and all its processes have ended.
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
            yield PrivateDomain(domain, descriptor)
        finally:
            os.close(descriptor)
        return
    raise DomainError(f"all ROS domains from {_DOMAINS.start} to {_DOMAINS.stop - 1} are in use by other runs")
