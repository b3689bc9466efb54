"""The unit of the atlas: one landmark map of one GVG edge, tied to its two meet points.

The edge frame has its origin at the meet point departed from and its x axis through the terminal
meet point (paper, section III-A), so the terminal lies at (length, 0).
"""

from dataclasses import dataclass

from hslam_types.se2 import SE2, Array

TERMINAL_MIN_M = 0.5
"""A terminal nearer than this to the origin gives no direction: the edge frame keeps the departure's."""


@dataclass(frozen=True, slots=True, eq=False)
class EdgeMap:
    """One traversal's map in its edge frame (m, rad)."""

    traversal: int
    """Sequence number of the departure event that began it (unique within a run)."""
    arrival: int
    """Sequence number of the arrival event that ended it."""
    terminal_x: float
    """Distance between the two meet points; the terminal's y is zero by construction."""
    landmarks: Array
    """Positions, n x 2."""
    covariance: Array
    """(2 + 2n) x (2 + 2n): the terminal first, then the landmarks; symmetric, positive semi-definite
    (the terminal's y row is zero: the frame is defined through it)."""
    sightings: tuple[int, ...]
    """How often each landmark was seen, length n."""
    departure_heading: float
    """Direction of the branch departed by, in the edge frame (the rotation that aligned it, negated)."""
    arrival_heading: float
    """Direction in which the branch come along (`NodeView.reference_bearing`) leaves the terminal, in the edge frame
    (pi for a straight edge): it ties the bearings of the arrival's node view to the map."""
    robot_at_arrival: SE2
    """Pose of base_link at the arrival event."""
    path_length_m: float
    """Distance driven from departure to arrival."""

    @property
    def size(self) -> int:
        """The number of landmarks."""
        return len(self.landmarks)


@dataclass(frozen=True, slots=True, eq=False)
class FrameLink:
    """How the next traversal's start sits in the last edge's frame, measured while turning at the node.

    ``departure_in_edge`` is the pose, in the edge frame of ``traversal``, of the frame that starts at the
    meet point and faces the branch departed by at event ``departure``; ``covariance`` is 3 x 3.
    """

    traversal: int
    departure: int
    departure_in_edge: SE2
    covariance: Array
