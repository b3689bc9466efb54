"""How every executable of the suite starts, spins and ends."""

import sys
from collections.abc import Callable

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node

from hslam_types.errors import HslamError

_POLL_S = 0.2
"""Longest time to notice a signal. `spin()` of these executors misses SIGTERM or runs nothing (rclpy 7.1.6)."""


def run(make_node: Callable[[], Node], done: Callable[[Node], bool] = lambda _: False) -> None:
    """Run one node until ``done``, Ctrl-C or SIGTERM, then destroy it; exits 1 with one line on a HslamError.

    The node's ``close()``, where it has one, is called before it is destroyed (to close files, to stop motors).
    """
    rclpy.init(args=sys.argv)
    node: Node | None = None
    code = 0
    try:
        node = make_node()
        executor = EventsExecutor()
        executor.add_node(node)
        while rclpy.ok() and not done(node):
            executor.spin_once(timeout_sec=_POLL_S)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except rclpy_implementation.RCLError:
        # A signal in the middle of a callback takes the context from under its next publish.
        if rclpy.ok():
            raise
    except HslamError as error:
        sys.stderr.write(f"{node.get_name() if node else sys.argv[0]}: {error}\n")
        code = 1
    finally:
        if node is not None:
            if hasattr(node, "close"):
                node.close()
            node.destroy_node()
        rclpy.try_shutdown()
    sys.exit(code)
