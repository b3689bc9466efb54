"""The GVG level, by whatever sensor: what a node, a bag loop or a simulation steps, and how it is made for a sensor."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from hslam_gvg.config import GvgConfig
from hslam_gvg.follow_config import FollowConfig, RingFollowConfig
from hslam_gvg.graph_follower import GraphFollower
from hslam_gvg.graph_watcher import GraphWatcher
from hslam_gvg.guards.ring_guard import RingGuardConfig
from hslam_gvg.local_graph.graph_config import LocalGraphConfig, RingGraphConfig
from hslam_gvg.ranging.scan_map_config import ScanMapConfig
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_gvg.server import GvgServer
from hslam_gvg.states import GvgOutput
from hslam_types.config import Configuration, parameter
from hslam_types.errors import ConfigurationError
from hslam_types.gvg_events import GvgGoal, NodeView
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import SCOUT_RING, OdometrySample, RangeScan, SonarSweep

C = TypeVar("C", bound=Configuration)

RING, SCAN = "ring", "scan"
"""Names of the sources: sonars in a ring, or a scanning range finder."""
LAWS, GRAPH, NONE = "laws", "graph", "none"
"""Names of the ways to drive: by the paper's control laws, along the local graph, or not at all."""
RING_GRAPH, RING_WATCHED, SCAN_WATCHED = "ring by graph", "ring watched", "scan watched"
"""The levels that drive along the local graph of a ring's map, and that watch a robot that somebody else drives."""


@dataclass(frozen=True)
class SourceConfig(Configuration):
    """Which sensor shows the surroundings, and where it is mounted."""

    source: str = parameter(RING, "ring: hslam_msgs/SonarRing on `sonar`; scan: sensor_msgs/LaserScan on `scan`")
    drive: str = parameter(
        LAWS,
        "ring: by the paper's control laws (laws), or along the local graph (graph), as with a scanner always; none: "
        "somebody else drives, and is told nodes and edges",
    )
    scan_forward_m: float = parameter(
        0.0, "the scanner's place before base_link's origin", low=-5.0, high=5.0, unit="m"
    )
    scan_left_m: float = parameter(0.0, "the scanner's place to its left", low=-5.0, high=5.0, unit="m")
    scan_yaw: float = parameter(0.0, "direction of the scanner's x axis in base_link", low=-6.3, high=6.3, unit="rad")

    def __post_init__(self) -> None:
        """Check values and ranges; raises ConfigurationError."""
        super().__post_init__()
        if self.source not in (RING, SCAN):
            raise ConfigurationError(f"parameter 'source' must be {RING} or {SCAN}, not {self.source!r}")
        if self.drive not in (LAWS, GRAPH, NONE):
            raise ConfigurationError(f"parameter 'drive' must be {LAWS}, {GRAPH} or {NONE}, not {self.drive!r}")

    @property
    def level(self) -> str:
        """Which level that makes, a key of `CONFIGURATIONS`."""
        if self.drive == NONE:
            return SCAN_WATCHED if self.source == SCAN else RING_WATCHED
        return SCAN if self.source == SCAN else RING_GRAPH if self.drive == GRAPH else RING

    @property
    def scanner_in_base(self) -> SE2:
        """Pose of the scanner in base_link."""
        return SE2(self.scan_forward_m, self.scan_left_m, self.scan_yaw)


_BY_SCAN = (("", FollowConfig), ("map.", ScanMapConfig), ("graph.", LocalGraphConfig))
_BY_RING = (("", RingFollowConfig), ("map.", SonarMapConfig), ("graph.", RingGraphConfig), ("guard.", RingGuardConfig))
CONFIGURATIONS: Mapping[str, tuple[tuple[str, type[Configuration]], ...]] = {
    RING: (("", GvgConfig),),
    RING_GRAPH: _BY_RING,
    RING_WATCHED: _BY_RING,
    SCAN: _BY_SCAN,
    SCAN_WATCHED: _BY_SCAN,
}
"""By level (`SourceConfig.level`): the configurations of the level, each with the prefix of its parameters' names."""


class GvgLevel(Protocol):
    """Odometry and what a sensor shows go in, a command and events come out."""

    next_goal: GvgGoal | None

    @property
    def node(self) -> NodeView | None:
        """The node the robot stands at, from its arrival to its departure."""

    @property
    def map_in_odom(self) -> SE2:
        """The frame of the local map in odom: how the map has corrected what odometry says."""

    @property
    def room_m(self) -> float:
        """The clearance where the robot is."""

    @property
    def path_length_m(self) -> float:
        """The length of the traversal under way, so far; 0 without one."""

    @property
    def distance_left_m(self) -> float:
        """The way left to the target of the last straight drive."""

    def obstacle_points(self) -> Array:
        """Return the obstacle points of the local map, n x 2 (m, odom)."""

    def reset(self) -> None:
        """Forget the local map, the node and the goal, and stand still; what was under way is announced as lost."""

    def start(self, goal: GvgGoal, decided_ns: int | None = None) -> None:
        """Take a goal, which the next step begins; raises GvgError for one that cannot be carried out from here."""

    def step(self, odom: OdometrySample, heard: Any) -> GvgOutput:
        """Take one cycle's inputs and return the command and what there is to announce."""


def gvg_level(level: str, configurations: Sequence[Configuration]) -> GvgLevel:
    """Return a level of `CONFIGURATIONS`, by its configurations in their order there."""
    if level == RING:
        return GvgServer(_of(GvgConfig, configurations[0]))
    by_graph = GraphWatcher if level in (RING_WATCHED, SCAN_WATCHED) else GraphFollower
    if level in (RING_GRAPH, RING_WATCHED):
        ring_follow, sonar, ring_graph, guard = configurations
        return by_graph(
            _of(RingFollowConfig, ring_follow),
            _of(SonarMapConfig, sonar),
            _of(RingGraphConfig, ring_graph),
            _of(RingGuardConfig, guard),
        )
    follow, mapping, graph = configurations
    return by_graph(_of(FollowConfig, follow), _of(ScanMapConfig, mapping), _of(LocalGraphConfig, graph))


def level_from_mapping(values: Mapping[str, Any]) -> tuple[GvgLevel, SourceConfig]:
    """Return the level, and its source, by parameters as a node has them; raises ConfigurationError on a bad one."""
    own = {entry.name for entry in SourceConfig.parameters()}
    source = SourceConfig.from_mapping({name: value for name, value in values.items() if name in own})
    groups = CONFIGURATIONS[source.level]
    prefixes = [prefix for prefix, _ in groups if prefix]
    configurations = []
    for prefix, kind in groups:
        others = [other for other in prefixes if other != prefix] if not prefix else []
        mine = {
            name.removeprefix(prefix): value
            for name, value in values.items()
            if name not in own and name.startswith(prefix) and not name.startswith(tuple(others))
        }
        configurations.append(kind.from_mapping(mine))
    return gvg_level(source.level, configurations), source


class Hearing:
    """Joins what a sensor said in one cycle into what the level takes: running free that may be nothing, or several."""

    def __init__(self) -> None:
        """Begin with the Scout's ring, until another is heard of."""
        self._ring = SCOUT_RING

    def sweep(self, stamp_ns: int, sweeps: tuple[SonarSweep, ...]) -> SonarSweep:
        """Return the cycle's sweeps as one."""
        if sweeps:
            self._ring = sweeps[-1].ring
        if len(sweeps) == 1:
            return sweeps[0]
        return SonarSweep(stamp_ns, self._ring, tuple(ping for sweep in sweeps for ping in sweep.pings))

    def scan(self, _: int, scans: tuple[RangeScan, ...]) -> RangeScan | None:
        """Return the cycle's newest scan, None without one."""
        return scans[-1] if scans else None


def _of(kind: type[C], configuration: Configuration) -> C:
    if not isinstance(configuration, kind):
        raise ConfigurationError(f"{kind.__name__} expected, not {type(configuration).__name__}")
    return configuration
