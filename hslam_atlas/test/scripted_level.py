"""A GVG level and an EKF level that do what a test says, over an atlas of three nodes in a row."""

import math

import numpy as np

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import EdgeEnd
from hslam_atlas.localisation.locator import Locator
from hslam_atlas.localisation.place import Place
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.missions.mission import Happened, Sense
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2, Array

LENGTH_M = 12.0
EXACT = UncertainPose.exact(SE2())


def landmarks(seed: int) -> Array:
    """Return boxes along both walls of a corridor 12 m long and 2 m wide, in its frame."""
    rng = np.random.default_rng(seed)
    return np.column_stack((rng.uniform(0.0, LENGTH_M, 24), np.repeat([1.0, -1.0], 12)))


def edge_map(traversal: int, seed: int, arrival: int = 0) -> EdgeMap:
    """Return the map of a corridor, driven without noise."""
    points = landmarks(seed)
    covariance = 1e-4 * np.eye(2 + 2 * len(points))
    covariance[1, 1] = 0.0
    base = SE2(LENGTH_M, 0.0, 0.0)
    return EdgeMap(traversal, arrival, LENGTH_M, points, covariance, (9,) * len(points), 0.0, math.pi, base, LENGTH_M)


def row() -> AtlasState:
    """Return an atlas of nodes 0, 1 and 2 along the x axis of `map`, corridors 0 and 1 between them."""
    store = AtlasStore()
    graph, _ = store.load()
    for bearings in ([0.0], [math.pi, 0.0, 1.5], [math.pi]):
        kind = NodeKind.MEET_POINT if len(bearings) > 1 else NodeKind.BOUNDARY_POINT
        graph.add_node(kind, 1.0, bearings)
    back = UncertainPose.exact(SE2(0.0, 0.0, math.pi))
    for edge, (u, key, v) in enumerate(((0, 0, 1), (1, 1, 2))):
        graph.connect((EdgeEnd(u, key, EXACT), EdgeEnd(v, 0, back)), LENGTH_M, 1e-4, LENGTH_M, edge)
        store.put(edge, edge_map(edge, edge))
    return AtlasState(AtlasConfig(), graph, store, LookAlikes(1e-4))


def view(bearings: tuple[float, ...], x: float = 0.0) -> NodeView:
    """Return a node as it shows with `odom` parallel to `map`."""
    kind = NodeKind.MEET_POINT if len(bearings) > 1 else NodeKind.BOUNDARY_POINT
    return NodeView(kind, x, 0.0, 1.0, bearings)


class ScriptedLevel:
    """Says what happens; the robot drives as it is told, without noise, `odom` being `map`."""

    def __init__(self) -> None:
        self.sequence = 0
        self.traversal = -1

    def departs(self, bearings: tuple[float, ...], branch: int, x: float) -> Happened:
        """The robot leaves a node at ``x``."""
        event = self._event(EventKind.DEPARTURE, view(bearings, x), branch)
        self.traversal = event.sequence
        return Happened((event,), sense=self.sense(SE2(x, 0.0, bearings[branch]), SE2()))

    def arrives(self, bearings: tuple[float, ...], branch: int, x: float, seed: int) -> Happened:
        """The robot has driven the corridor of landmarks ``seed`` to a node at ``x``."""
        event = self._event(EventKind.ARRIVAL, view(bearings, x), branch, LENGTH_M)
        drive = edge_map(self.traversal, seed, event.sequence)
        return Happened((event,), (drive,), sense=self.sense(SE2(x, 0.0, 0.0), SE2(LENGTH_M, 0.0, 0.0)))

    def loses_its_way(self, sense: Sense) -> Happened:
        """The way is given up."""
        return Happened((self._event(EventKind.LOST),), sense=sense)

    def sense(self, base_in_odom: SE2, base_in_frame: SE2 | None, *, idle: bool = False, room_m: float = 1.0) -> Sense:
        """Return what is known of the robot at a pose."""
        return Sense(base_in_odom, self.traversal, base_in_frame, room_m=room_m, idle=idle)

    def _event(
        self, kind: EventKind, node: NodeView | None = None, branch: int = -1, length_m: float = 0.0
    ) -> GvgEvent:
        self.sequence += 1
        return GvgEvent(self.sequence, self.sequence, kind, node, branch, length_m)


def located(state: AtlasState) -> Locator:
    """Return a locator that knows the robot to stand at node 0."""
    locator = Locator(state)
    locator.places = [Place(0, EXACT, -1, 30.0, (0,), 0)]
    return locator
