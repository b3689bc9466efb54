"""Pytest plugin: all tests run in a ROS domain that nobody else on this machine or network is in."""

from collections.abc import Iterator

import pytest

from hslam_ros.private_domain import private_domain


@pytest.fixture(scope="session", autouse=True)
def ros_domain() -> Iterator[None]:
    """Put this process, and every one it starts, into a domain reserved for it."""
    with private_domain() as domain, pytest.MonkeyPatch.context() as patch:
        for name, value in domain.environment.items():
            patch.setenv(name, value)
        yield
