"""What the atlas consists of while it is being built."""

from dataclasses import dataclass, field

from hslam_atlas.config import AtlasConfig
from hslam_atlas.edge_maps import EdgeMaps
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.uncertain_pose import UncertainPose


@dataclass(frozen=True, slots=True)
class Merged:
    """Node ``gone`` has become part of ``kept``; ``branches`` maps its branch keys."""

    gone: int
    kept: int
    gone_in_kept: UncertainPose
    branches: dict[int, int]


@dataclass(slots=True)
class AtlasState:
    """Graph, maps and what was learnt about look-alikes, with the merges still to be announced."""

    config: AtlasConfig
    graph: AtlasGraph
    maps: EdgeMaps
    look_alikes: LookAlikes
    merged: list[Merged] = field(default_factory=list)
    """Merges done in this step, in order."""
    loosened: set[int] = field(default_factory=set)
    """Nodes that have lost an edge in this step."""
    closures: int = 0
    """Loops closed so far."""
