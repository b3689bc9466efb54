"""A place the robot may be at, and when one of several is beyond doubt."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hslam_atlas.config import AtlasConfig
from hslam_atlas.missions.mission import Sense
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.se2 import SE2

ODOM = -1
"""In place of a traversal: the robot is followed by odometry alone."""


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """The hypothesis that the robot is about a node, or on its way from one."""

    node: int
    frame_in_node: UncertainPose
    """Of the frame the robot is tracked in."""
    traversal: int
    """The traversal that has this frame, or `ODOM`."""
    evidence: float
    """Log-odds (nats) against being somewhere the atlas does not know."""
    keys: tuple[int | None, ...] = ()
    """Standing at the node: its branch for each branch in view. Empty elsewhere."""
    come: int = -1
    """Standing at the node: the branch in view the robot came along."""
    branch: int | None = None
    """On the way: the branch it left by, None where that is not known."""

    def base_in_node(self, sense: Sense) -> SE2 | None:
        """Return the robot's pose in the node's frame, None where nothing tracks it in the place's frame."""
        if self.traversal == ODOM:
            return self.frame_in_node.pose @ sense.base_in_odom
        if sense.base_in_frame is None or sense.traversal != self.traversal:
            return None
        return self.frame_in_node.pose @ sense.base_in_frame

    def by_odometry(self, sense: Sense, position_std_m: float, heading_std: float) -> "Place | None":
        """Return the same place off the graph, tracked by odometry from now on; None where it is not tracked."""
        base_in_node = self.base_in_node(sense)
        if base_in_node is None:
            return None
        odom_in_node = base_in_node @ sense.base_in_odom.inverse()
        # The spread is that of the robot's pose; it is kept where the robot is, not at the origin of odom.
        frame = UncertainPose.diagonal(odom_in_node, position_std_m, heading_std)
        return replace(self, frame_in_node=frame, traversal=ODOM, keys=(), come=-1, branch=None)


def beyond_doubt(places: Sequence[Place], config: AtlasConfig) -> Place | None:
    """Return the place that has enough evidence and a clear lead over every other one, None if none has."""
    if not places:
        return None
    best, *others = sorted(places, key=lambda place: -place.evidence)
    rival = max((place.evidence for place in others), default=0.0)
    sure = best.evidence >= config.close_evidence and best.evidence - rival >= config.close_margin
    return best if sure else None
