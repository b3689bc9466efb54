"""How every executable of the suite starts, spins and ends."""

import gc
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from hslam_ros.executor import make_executor
from hslam_ros.parameters import refuse_unknown
from hslam_types.errors import HslamError

_POLL_S = 0.2
"""Longest time to notice a signal. `spin()` of these executors misses SIGTERM or runs nothing (rclpy 7.1.6)."""


class _Stop:
    """Notes that a signal asked the process to end.

    rclpy's own handlers would take the context away in the middle of whatever callback runs; the next publish then
    fails, or the process aborts in native code. Noting the wish and ending between two callbacks does neither.
    """

    def __init__(self) -> None:
        self.asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._ask)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        del number, frame
        self.asked = True


def run(make_node: Callable[[], Node], done: Callable[[Node], bool] = lambda _: False) -> None:
    """Run one node until ``done``, Ctrl-C or SIGTERM, then destroy it; exits 1 with one line on a HslamError.

    A parameter that the node does not know is such an error.

    The node's ``close()``, where it has one, is called before it is destroyed (to close files, to stop motors).
    """
    stop = _Stop()
    rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
    node: Node | None = None
    code = 0
    try:
        node = make_node()
        refuse_unknown(node)
        executor = make_executor()
        executor.add_node(node)
        gc.freeze()  # what lives as long as the node is not searched for garbage again and again
        while not stop.asked and not done(node):
            executor.spin_once(timeout_sec=_POLL_S)
    except HslamError as error:
        code = _tell(node, error)
    finally:
        if node is not None:
            try:
                if hasattr(node, "close"):
                    node.close()
            except HslamError as error:
                code = _tell(node, error)
            node.destroy_node()
        rclpy.try_shutdown()
    sys.exit(code)


def _tell(node: Node | None, error: HslamError) -> int:
    """Write an error's one line; return the exit status."""
    sys.stderr.write(f"{node.get_name() if node else Path(sys.argv[0]).name}: {error}\n")
    return 1
