"""A bag of a robot that somebody drove becomes an atlas: all levels over its odometry and scans, in this process."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from hslam_atlas.atlas_messages import atlas_to_msg
from hslam_atlas.config import AtlasConfig
from hslam_atlas.picture import node_poses, parts
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_bags.bag import Bag
from hslam_bags.cycles import in_portions, in_stamp_order, stamp_of
from hslam_bags.errors import BagError
from hslam_bags.grown_types import Decoder
from hslam_bags.recorder import Recorder
from hslam_bags.topic_choice import TopicChoice
from hslam_bringup.run_options import RunOptions
from hslam_bringup.run_record import RunRecord
from hslam_bringup.scanner_mounting import STATIC, scanner_in_base
from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_gvg.level import NONE, SCAN, GvgLevel, level_from_mapping
from hslam_landmarks.scan_landmarks import ScanLandmarks, lookout_from_mapping
from hslam_ros import conversions
from hslam_ros.continuity import Continuity
from hslam_ros.scan_conversion import scan_from_msg
from hslam_ros.stamps import NS_PER_S
from hslam_types.gvg_events import EventKind
from hslam_types.se2 import SE2

_SHOW_EVERY = 200
"""Cycles between two looks at the run."""
WATCHED = {"gvg": {"source": SCAN, "drive": NONE}}
"""Parameters by node that make the GVG level watch."""


@dataclass(frozen=True)
class MapTopics:
    """What a bag calls the robot's odometry and scans."""

    odom: str = "/odom"
    scan: str = "/scan"


@dataclass(frozen=True)
class Mapped:
    """What became of a bag."""

    nodes: int
    edges: int
    parts: int
    """Parts of the atlas that nothing connects."""
    arrivals: int
    losses: int
    """How often the robot was lost, and began anew."""
    closures: int
    """Loops closed."""
    driven_m: float
    """By odometry."""
    seconds: float
    """Of the bag's time."""

    @property
    def fields(self) -> dict[str, object]:
        """The fields of the report."""
        return asdict(self)


class _MapRun:
    """The three levels, stepped by a bag's cycles and recorded under the topics of the nodes."""

    def __init__(
        self, options: RunOptions, level: GvgLevel, landmarks: ScanLandmarks, store: AtlasStore, record: RunRecord
    ) -> None:
        self.gvg, self._landmarks, self._record = level, landmarks, record
        self.ekf = EkfServer(EkfConfig.from_mapping(options.node_settings("ekf")))
        self.atlas = AtlasServer(AtlasConfig.from_mapping(options.node_settings("atlas") | {"mission": "none"}), store)
        self._continuity = Continuity()
        self._last: SE2 | None = None
        self._first_ns = self._newest_ns = 0
        self._driven_m = 0.0
        self._arrivals = self._losses = 0

    def step(self, odom_msg: Any, scan_msg: Any, scanner: SE2) -> None:
        """Take one cycle's odometry, and the scan if there was one; raises MessageError where they are none."""
        odom = conversions.odometry_from_msg(odom_msg)
        scan = None if scan_msg is None else scan_from_msg(scan_msg, scanner)
        if self._continuity.broken_by(odom):
            self.gvg.reset()
        told = self.gvg.step(odom, scan).events
        # What the local map has corrected is the better odometry: wheels and gyros of old bend by degrees a metre.
        odom_in_map = self.gvg.map_in_odom.inverse()
        odom = replace(odom, base_in_odom=odom_in_map @ odom.base_in_odom, pose_covariance=None)
        events = tuple(event.moved(odom_in_map) for event in told)
        look = None if scan is None else self._landmarks.hear(scan)
        mapped = self.ekf.step(odom, look, events)
        changed = self.atlas.step(events, mapped.edge_maps, mapped.links).changed
        self._arrivals += sum(event.kind is EventKind.ARRIVAL for event in events)
        self._losses += sum(event.kind is EventKind.LOST for event in events)
        here, last = odom.base_in_odom, self._last
        self._driven_m += 0.0 if last is None else math.dist(here[:2], last[:2])
        self._first_ns = odom.stamp_ns if last is None else self._first_ns
        self._last, self._newest_ns = here, odom.stamp_ns

        stamp_ns, put = odom.stamp_ns, self._record.put
        put("/odom", conversions.odometry_to_msg(odom), stamp_ns)
        if scan_msg is not None:
            put("/scan", scan_msg, stamp_ns)
        if look is not None:
            put("/landmarks", conversions.landmarks_to_msg(look), stamp_ns)
        for event in events:
            put("/gvg/events", conversions.event_to_msg(event), stamp_ns)
        for edge_map in mapped.edge_maps:
            put("/ekf/edge_maps", conversions.edge_map_to_msg(edge_map, stamp_ns), stamp_ns)
        for link in mapped.links:
            put("/ekf/frame_links", conversions.link_to_msg(link, stamp_ns), stamp_ns)
        if changed:
            put("/atlas/atlas", atlas_to_msg(self.atlas, node_poses(self.atlas.state.graph), stamp_ns), stamp_ns)

    def summary(self) -> Mapped:
        """Return what there is."""
        graph = self.atlas.state.graph
        return Mapped(
            len(graph.nodes),
            len(graph.edges),
            len(parts(graph)),
            self._arrivals,
            self._losses,
            self.atlas.state.closures,
            self._driven_m,
            (self._newest_ns - self._first_ns) / NS_PER_S,
        )


def map_bag(bag: Bag, topics: MapTopics, options: RunOptions, show: Callable[[float], None]) -> Mapped:
    """Make ``options.atlas`` of an open bag's odometry and scans, and a bag of what was found in them.

    The odometry in that bag is as the local map has corrected it.

    ``show`` is told the share of the bag that is done.  Where the scanner is mounted the bag's
    static transforms say, else the settings of gvg and scan_landmarks.  Raises BagError if the bag is damaged or lacks
    a topic, MessageError if it holds what no node takes, ConfigurationError on a bad setting, StoreError if the atlas
    cannot be written.
    """
    for topic in (topics.odom, topics.scan):
        if not bag.counts.get(topic):
            raise BagError(bag.path, f"topic {topic}", f"is not in the bag; it has {', '.join(sorted(bag.counts))}")
    level, source = level_from_mapping(options.node_settings("gvg") | WATCHED["gvg"])
    landmarks, _ = lookout_from_mapping(options.node_settings("scan_landmarks"))
    decoder = Decoder(bag.topics.values())
    scanner: SE2 | None = None
    messages = bag.messages(TopicChoice((topics.odom, topics.scan)))
    with Recorder(options.bag) as recorder, AtlasStore(options.atlas) as store:
        run = _MapRun(options, level, landmarks, store, RunRecord(recorder))
        for cycle, portion in enumerate(in_portions(in_stamp_order(messages, stamp_of), topics.odom)):
            if not portion.complete:
                continue
            newest = {message.topic: decoder.decode(message) for message in portion.messages}
            odom, scan = newest[topics.odom], newest.get(topics.scan)
            if scanner is None and scan is not None:
                told = bag.counts.get(STATIC)
                found = scanner_in_base(bag, odom.child_frame_id, scan.header.frame_id) if told else None
                scanner = source.scanner_in_base if found is None else found
            run.step(odom, scan, scanner or source.scanner_in_base)
            if cycle % _SHOW_EVERY == 0:
                show(cycle / bag.counts[topics.odom])
        run.atlas.save_rest()
        return run.summary()
