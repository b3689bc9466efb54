"""What one node tells the others once it has handled a cycle."""

from typing import NamedTuple


class Answer(NamedTuple):
    """A node's answer to one cycle."""

    stamp_ns: int
    """It has handled everything up to and including this."""
    outputs: int
    """How many messages of its counted topics it has published so far."""
    finished: bool
    """Whether the mission has ended."""
