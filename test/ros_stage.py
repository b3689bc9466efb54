"""Pytest plugin: nodes of the test's own process on one executor, run until something holds."""

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Protocol, TypeVar

import pytest
import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from hslam_ros.executor import make_executor

N = TypeVar("N", bound=Node)


def ros_arguments(parameters: Mapping[str, object]) -> list[str]:
    """Return the command line that gives a node these parameters; texts are taken for YAML."""
    arguments = ["--ros-args"]
    for name, value in parameters.items():
        arguments += ["-p", f"{name}:={str(value).lower() if isinstance(value, bool) else value}"]
    return arguments


class Stage:
    """Nodes on one executor (nodes moved between executors lose wake-ups) in the default context."""

    def __init__(self, **parameters: object) -> None:
        """Open the context, with parameters for every node that is made in it."""
        rclpy.init(args=ros_arguments(parameters), signal_handler_options=SignalHandlerOptions.NO)
        self._nodes: list[Node] = []
        self._executor = make_executor()
        self._closed = False

    def add(self, node: N) -> N:
        """Run a node from now on; return it."""
        self._nodes.append(node)
        self._executor.add_node(node)
        return node

    def spin_until(self, predicate: Callable[[], bool], timeout_s: float = 20.0) -> None:
        """Run callbacks until something holds; fails after ``timeout_s`` of wall time."""
        deadline = time.monotonic() + timeout_s
        while not predicate():
            assert time.monotonic() < deadline, "nothing came in time"
            self._executor.spin_once(timeout_sec=0.05)

    def wait(self, future: Any) -> Any:
        """Return what a future brings."""
        self.spin_until(future.done)
        return future.result()

    def call(self, caller: Node, kind: Any, name: str, request: Any) -> Any:
        """Call a service once it is there; return its answer."""
        client = caller.create_client(kind, name)
        self.spin_until(client.service_is_ready)
        return self.wait(client.call_async(request))

    def close(self) -> None:
        """End the executor, then the nodes, then the context."""
        if self._closed:
            return
        self._closed = True
        self._executor.shutdown()
        for node in self._nodes:
            if hasattr(node, "close"):
                node.close()
            node.destroy_node()
        rclpy.try_shutdown()


S = TypeVar("S", bound=Stage)


class Staged(Protocol):
    """What the fixture gives."""

    def __call__(self, kind: type[S], **parameters: object) -> S:
        """Open a stage with parameters for its nodes; it is closed after the test."""


@pytest.fixture
def staged() -> Iterator[Staged]:
    """Give a function that opens a stage of a kind."""
    stages: list[Stage] = []

    def open_stage(kind: type[S], **parameters: object) -> S:
        stage = kind(**parameters)
        stages.append(stage)
        return stage

    yield open_stage
    for stage in stages:
        stage.close()
    rclpy.try_shutdown()  # one that failed to open has left its context
