"""What one node tells the others once it has handled a cycle."""

from typing import NamedTuple

from hslam_types.se2 import SE2


class Answer(NamedTuple):
    """A node's answer to one cycle."""

    stamp_ns: int
    """It has handled everything up to and including this."""
    outputs: int
    """How many messages of its counted topics it has published so far."""
    finished: bool
    """Whether the mission has ended."""
    state: str = ""
    """What the node is doing, in one word."""
    clearance_m: float = 0.0
    """From the GVG level: to the nearest obstacle, as far as it matters."""
    base_in_odom: SE2 = SE2()
    """From the GVG and EKF levels."""
    traversal: int = -1
    """From the EKF level: the traversal whose frame the robot is tracked in, -1 without one."""
    base_in_edge: SE2 | None = None
    """Pose of base_link in that frame."""
    next_event: int = 0
    """From the EKF level: sequence of the GVG event that it takes next; 0 before the first."""
