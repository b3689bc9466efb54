"""Keeps two runs on one machine from hearing each other, and the rest of the network from reaching either."""

import dataclasses
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ament_index_python.packages import get_package_share_directory

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
    """File descriptor of the socket that holds it; processes that inherit it keep the domain as long as they live."""

    @property
    def environment(self) -> dict[str, str]:
        """What the processes of the run need in their environment."""
        return {"ROS_DOMAIN_ID": str(self.number)} | within_this_machine()


def within_this_machine() -> dict[str, str]:
    """Return the environment of nodes that nobody on the network can reach: they have loopback and shared memory alone.

    ROS's own discovery range LOCALHOST is not enough: it limits whom nodes look for, while their sockets stay open to
    whoever knows the ports.  The profile limits both, but only where the range leaves it alone.
    """
    profile = Path(get_package_share_directory("hslam_ros")) / "fast_dds.xml"
    return {
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile),
        "SKIP_DEFAULT_XML_FILE": "1",  # a profile that lies in the working directory
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
        "ROS_LOCALHOST_ONLY": "",
        "ROS_DISCOVERY_SERVER": "",
    }


@contextmanager
def private_domain() -> Iterator[PrivateDomain]:
    """Reserve a ROS domain for a run; raises DomainError if none is free.

    The reservation is a socket's name in Linux' abstract namespace, which all share who share the network, and thus the
    domains, containers too; the system frees it when the run and all its processes have ended.
    """
    for domain in _DOMAINS:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as reservation:
            try:
                reservation.bind(f"\0hslam_domain_{domain}")
            except OSError:
                continue
            yield PrivateDomain(domain, reservation.fileno())
            return
    raise DomainError(f"all ROS domains from {_DOMAINS.start} to {_DOMAINS.stop - 1} are in use by other runs")
