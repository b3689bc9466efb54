"""How an executable begins: until all it imports is there, Ctrl-C ends it without a word.

Imports take a second or two, and Python answers a signal in their midst by a traceback that tells nobody anything.
"""

import importlib
import signal
from collections.abc import Callable


def executable(module: str) -> Callable[[], None]:
    """Return a function that imports a module, whole, and then calls its ``main()``."""

    def start() -> None:
        meanwhile = signal.getsignal(signal.SIGINT)
        if meanwhile is signal.default_int_handler:  # else a shell has it ignored, for a process in the background
            signal.signal(signal.SIGINT, signal.SIG_DFL)
        main = importlib.import_module(module).main
        signal.signal(signal.SIGINT, meanwhile)
        main()

    return start
