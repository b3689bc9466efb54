"""Pytest plugin: tests run in a ROS domain that nobody else on this machine or network is in."""

import gc
from collections.abc import Iterator

import pytest

from hslam_ros.private_domain import private_domain


@pytest.fixture(scope="session", autouse=True)
def own_domain() -> Iterator[None]:
    """Put this process, and every one it starts, into a domain reserved for it."""
    with private_domain() as domain, pytest.MonkeyPatch.context() as patch:
        for name, value in domain.environment.items():
            patch.setenv(name, value)
        yield


@pytest.fixture(autouse=True)
def _leave_the_domain(request: pytest.FixtureRequest) -> Iterator[None]:
    """Let no participant outlive its test: a domain on one machine has room for a few dozen, then peers are not found.

    Nodes with actions are cyclic garbage, which otherwise goes whenever Python pleases.
    """
    yield
    if "staged" in request.fixturenames or hasattr(request.module, "rclpy"):
        gc.collect()
