"""The way a robot drove and what its ranges told, from a run's bag, in the frame of the atlas's picture.

The atlas keeps edge-maps, not the ways between them.  The bag has them: the EKF level is run over it once more, and
every pose it finds in an edge's frame is placed where the picture has that edge.
"""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hslam_atlas.graph import AtlasGraph, Edge
from hslam_atlas.picture import Picture
from hslam_bags.bag import Bag
from hslam_bags.cycles import in_portions, in_stamp_order, stamp_of
from hslam_bags.errors import BagError
from hslam_bags.grown_types import Decoder
from hslam_bags.topic_choice import TopicChoice
from hslam_bringup.bag_loop import TOPICS
from hslam_bringup.errors import RunError
from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_ros import conversions
from hslam_ros.scan_conversion import scan_from_msg
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2, Array

_RANGES = ("/scan", "/sonar")
_DISC_RAYS = 32
_DISC_MOST_M, _DISC_SHORT_M = 1.5, 0.1
"""A larger disc is heard where no wall is looked at squarely; one reaches not quite to the wall that gave it."""
_WALL_PARTS = tuple(math.radians(2.0 * part) for part in range(-4, 5))
"""Of a cone: how far a wall that is looked at squarely surely goes on to either side."""
_SQUARE = 1.3
"""An echo no farther than this multiple of the nearest one comes from a wall that the sonar looks at squarely.  Others
may have come round a corner: they say nothing of where a wall is, or that there is none."""
_SHOW_EVERY = 200
_SAME_M, _UPDATED_M = 0.05, 1.0
"""An edge and the drive it was made of differ by less, if one drive or if several made it; by more where bag and atlas
are of different runs."""


@dataclass(frozen=True, slots=True, eq=False)
class Station:
    """One cycle: when, in which drive, where in that drive's frame, and what was ranged."""

    stamp_ns: int
    traversal: int
    is_arrived: bool
    """Whether the frame is the finished edge-map's already, or still the departure's."""
    base_in_frame: SE2
    beams: Array
    """n x 4: x, y of a beam's end in base_link (m), whether something is there, whether the way there is free."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacedStation:
    """A pose of base_link in the picture, with the beams' ends there."""

    stamp_ns: int
    base: SE2
    beams: Array
    edge: int
    is_between: bool
    """Whether it is on the way between the edge's nodes, by the drive that made the edge."""


class DrivenWay:
    """What a bag tells of a run: its cycles, and the edge-maps its EKF makes of them."""

    def __init__(self, path: Path, *, with_ranges: bool, show: Callable[[float], None]) -> None:
        """Run the EKF level over a bag; raises BagError where it cannot be read. ``show`` is told the share done."""
        self.path = path
        self._round: deque[float] = deque(maxlen=1)
        """The ranges of the last round of pings, from base_link's origin."""
        self.stations: list[Station] = []
        self.edge_maps: dict[int, EdgeMap] = {}
        """By traversal."""
        ekf = EkfServer(EkfConfig())
        with Bag(path) as bag:
            decoder = Decoder(bag.topics.values())
            for topic in TOPICS:
                if not bag.counts.get(topic):
                    raise BagError(path, f"topic {topic}", "is not in the bag, and no way is found without it")
            ranges = next((topic for topic in _RANGES if bag.counts.get(topic)), None) if with_ranges else None
            topics = (*TOPICS, ranges) if ranges else TOPICS
            for cycle, portion in enumerate(
                in_portions(in_stamp_order(bag.messages(TopicChoice(topics)), stamp_of), "/odom")
            ):
                if not portion.complete:
                    continue
                if cycle % _SHOW_EVERY == 0:
                    show(cycle / bag.counts["/odom"])
                heard: dict[str, list[Any]] = {topic: [] for topic in topics}
                for message in portion.messages:
                    heard[message.topic].append(decoder.decode(message))
                self._step(ekf, heard, heard[ranges] if ranges else [], ranges == "/scan")

    def _step(self, ekf: EkfServer, heard: dict[str, list[Any]], ranges: list[Any], are_scans: bool) -> None:
        odom = conversions.odometry_from_msg(heard["/odom"][-1])
        looks = [conversions.landmarks_from_msg(msg) for msg in heard["/landmarks"]]
        events = tuple(conversions.event_from_msg(msg) for msg in heard["/gvg/events"])
        mapped = ekf.step(odom, looks[-1] if looks else None, events)
        self.edge_maps.update({edge_map.traversal: edge_map for edge_map in mapped.edge_maps})
        if mapped.base_in_edge is None:
            return
        beams = [_scan_ends(msg) if are_scans else self._sonar_ends(msg) for msg in ranges]
        ends = np.concatenate(beams) if beams else np.empty((0, 4))
        self.stations.append(Station(odom.stamp_ns, mapped.traversal, mapped.arrived, mapped.base_in_edge, ends))

    def _sonar_ends(self, msg: Any) -> Array:
        """Return what a sweep shows in base_link: a disc that the nearest echo of a round leaves free, and walls."""
        sweep = conversions.sonar_from_msg(msg)
        if self._round.maxlen != len(sweep.ring.bearings):
            self._round = deque(maxlen=len(sweep.ring.bearings))
        pings = [(sweep.ring.mount_radius_m + ping.range_m, sweep.ring.bearings[ping.sensor]) for ping in sweep.pings]
        self._round.extend(reach for reach, _ in pings)
        if len(self._round) < len(sweep.ring.bearings) or math.isinf(nearest := min(self._round)):
            return np.empty((0, 4))
        radius = min(nearest - _DISC_SHORT_M, _DISC_MOST_M)
        disc = [(radius, 2.0 * math.pi * ray / _DISC_RAYS, 0.0, 1.0) for ray in range(_DISC_RAYS)]
        walls = [
            (reach, bearing + part, 1.0, 0.0)
            for reach, bearing in pings
            if reach <= _SQUARE * nearest
            for part in _WALL_PARTS
        ]
        reach, bearing, hit, free = np.array(disc + walls).T
        return np.column_stack((reach * np.cos(bearing), reach * np.sin(bearing), hit, free))

    def placed(self, graph: AtlasGraph, picture: Picture) -> list[PlacedStation]:
        """Return the stations of all drives that an edge of the picture is made of, in order of time.

        Raises RunError where the edges were not made of this bag's drives.
        """
        frames: dict[int, tuple[int, SE2, bool]] = {}
        for edge_id, frame in picture.edge_frames.items():
            edge = graph.edges[edge_id]
            for traversal in edge.traversals:
                edge_map = self.edge_maps.get(traversal)
                if edge_map is None or not _is_of(edge, edge_map):
                    raise RunError(f"{self.path}: not the bag of the atlas's run (drive {traversal} of edge {edge_id})")
                if (end := _began_at(edge, traversal, edge_map, graph)) is not None:
                    origin = frame if end == 0 else frame @ SE2(edge.terminal_x, 0.0, math.pi)
                    frames[traversal] = edge_id, origin, traversal == edge.traversals[0]
        found = []
        for station in self.stations:
            if station.traversal not in frames:
                continue
            edge_id, origin, is_first = frames[station.traversal]
            heading = 0.0 if station.is_arrived else self.edge_maps[station.traversal].departure_heading
            base = origin @ SE2(0.0, 0.0, heading) @ station.base_in_frame
            beams = station.beams.copy()
            beams[:, :2] = base.apply_all(beams[:, :2])
            found.append(PlacedStation(station.stamp_ns, base, beams, edge_id, is_first and not station.is_arrived))
        return found


def _is_of(edge: Edge, edge_map: EdgeMap) -> bool:
    """Whether an edge can have been made of a drive."""
    away_m = max(abs(edge.terminal_x - edge_map.terminal_x), abs(edge.path_length_m - edge_map.path_length_m))
    return away_m < (_SAME_M if len(edge.traversals) == 1 else _UPDATED_M)


def _began_at(edge: Edge, traversal: int, edge_map: EdgeMap, graph: AtlasGraph) -> int | None:
    """Return the end (0 or 1) of its edge at which a drive began, None where that cannot be told."""
    if traversal == edge.traversals[0]:
        return 0
    ends = [
        end for end in (0, 1) if any(seen == edge_map.arrival for seen, _ in graph.nodes[edge.ends[end].node].visits)
    ]
    return 1 - ends[0] if len(ends) == 1 else None


def _scan_ends(msg: Any) -> Array:
    """Return the ends of a scan's beams in base_link; the scanner is taken to sit at its origin."""
    scan = scan_from_msg(msg, SE2())
    told = (scan.ranges >= scan.range_min_m) & ((scan.ranges <= scan.range_max_m) | np.isposinf(scan.ranges))
    hit = told & (scan.ranges <= scan.range_max_m)
    ranges = np.where(hit, scan.ranges, scan.range_max_m)
    ends = np.column_stack((ranges * np.cos(scan.bearings), ranges * np.sin(scan.bearings), hit, told))
    return ends[told]
