"""What a finished run left on disk, as the plain values that are scored and drawn."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hslam_atlas.graph import AtlasGraph, Node
from hslam_atlas.picture import composed
from hslam_atlas.pose_graph import optimised
from hslam_atlas.store import AtlasStore
from hslam_bags.bag import Bag
from hslam_bags.grown_types import Decoder
from hslam_bags.topic_choice import TopicChoice
from hslam_bringup.errors import RunError
from hslam_report.explored import (
    ExploredEdge,
    ExploredGraph,
    ExploredNode,
    PlacedEdgeMap,
    Visit,
    edge_frame_in_map,
    true_meet_point,
)
from hslam_report.landmark_score import rigid_fit
from hslam_report.path_figures import DrivenPath
from hslam_report.visits import position
from hslam_ros.conversions import event_from_msg, odometry_from_msg
from hslam_types.gvg_events import GvgEvent
from hslam_types.se2 import SE2, wrap

CLOSED_M = 0.5
"""Of edges with true ends nearer than this a few centimetres at one of them turn the frame by degrees: closed ones."""

_TOPICS = ("/odom", "/ground_truth", "/gvg/events", "/bumper")


@dataclass(frozen=True, eq=False)
class RunLog:
    """What was recorded: poses a step, events, contacts."""

    driven: DrivenPath
    end_ns: int
    events: dict[int, GvgEvent]
    """By sequence number."""
    step_of_event: dict[int, int]
    """Row of ``driven`` at which each event was announced."""
    contacts: int

    def meet_point(self, sequence: int) -> tuple[float, float]:
        """Return where the node of an event truly was (m, in map)."""
        node = self.events[sequence].node
        if node is None:
            raise RunError(f"event {sequence} of the bag tells no node, though the atlas counts it as a visit")
        step = self.step_of_event[sequence]
        in_map, in_odom = self.driven.in_map[step], self.driven.in_odom[step]
        return true_meet_point(SE2(*in_map.tolist()), SE2(*in_odom.tolist()), node)


def read_log(bag: Path) -> RunLog:
    """Read a run's bag; raises BagError on a damaged one, RunError on one without the truth to score against."""
    odom: dict[int, SE2] = {}
    truth: dict[int, SE2] = {}
    events: dict[int, GvgEvent] = {}
    contacts = 0
    with Bag(bag) as opened:
        decoder = Decoder(opened.topics.values())
        for stored in opened.messages(TopicChoice(_TOPICS)):
            msg = decoder.decode(stored)
            if stored.topic == "/gvg/events":
                event = event_from_msg(msg)
                events[event.sequence] = event
            elif stored.topic == "/bumper":
                contacts += bool(msg.data)
            else:
                sample = odometry_from_msg(msg)
                (odom if stored.topic == "/odom" else truth)[sample.stamp_ns] = sample.base_in_odom
    stamps = sorted(odom.keys() & truth.keys())
    if not stamps:
        raise RunError(f"{bag} holds no ground_truth; only simulated runs can be scored")
    rows = {stamp_ns: row for row, stamp_ns in enumerate(stamps)}
    driven = DrivenPath(np.array([odom[s] for s in stamps]), np.array([truth[s] for s in stamps]))
    return RunLog(driven, stamps[-1], events, {n: rows[e.stamp_ns] for n, e in events.items()}, contacts)


def explored_graph(graph: AtlasGraph, log: RunLog) -> ExploredGraph:
    """Return the atlas's graph with the true place of every visit."""
    order = {node.id: node.slots() for node in graph.nodes.values()}
    nodes = tuple(_explored_node(node, len(order[node.id]), log) for node in graph.nodes.values())
    edges = tuple(
        ExploredEdge(
            u=edge.ends[0].node,
            v=edge.ends[1].node,
            branch_u=order[edge.ends[0].node].index(edge.ends[0].branch),
            branch_v=order[edge.ends[1].node].index(edge.ends[1].branch),
            length_m=edge.path_length_m,
        )
        for edge in graph.edges.values()
    )
    return ExploredGraph(nodes, edges)


def _explored_node(node: Node, degree: int, log: RunLog) -> ExploredNode:
    visits = tuple(Visit(sequence, *log.meet_point(sequence)) for sequence, _ in node.visits)
    return ExploredNode(node.id, node.kind, degree, node.clearance_m, visits)


def placed_maps(store: AtlasStore, graph: AtlasGraph, explored: ExploredGraph, log: RunLog) -> list[PlacedEdgeMap]:
    """Return every stored edge-map with its true frame and its landmarks in both pictures of the whole."""
    if not graph.nodes:
        return []
    oldest = min(graph.nodes)
    chain, picture = composed(graph, store, oldest), optimised(graph, store, oldest)
    at = {node.id: position(node) for node in explored.nodes}
    placed = []
    for edge in graph.edges.values():
        start = edge.ends[0]
        if edge.id not in picture.landmarks:
            continue
        edge_map = store.get(edge.id)
        ends = [log.meet_point(edge_map.traversal), log.meet_point(edge_map.arrival)]
        if np.hypot(*np.subtract(ends[0], at[start.node])) > np.hypot(*np.subtract(ends[1], at[start.node])):
            ends.reverse()  # the map was taken from the edge's other end
        placed.append(
            PlacedEdgeMap(
                name=f"edge {edge.id}",
                terminal_x=edge_map.terminal_x,
                landmarks=edge_map.landmarks,
                covariance=edge_map.covariance,
                frame_in_map=edge_frame_in_map(ends[0], ends[1]),
                chained=chain.landmarks[edge.id],
                optimised=picture.landmarks[edge.id],
                closed=math.dist(*ends) < CLOSED_M,
            )
        )
    return _with_closed_ones_turned(placed)


def _with_closed_ones_turned(maps: list[PlacedEdgeMap]) -> list[PlacedEdgeMap]:
    """Turn the frames of closed edges as the chained picture has them: one meet point alone gives no direction."""
    opened = [placed for placed in maps if not placed.closed]
    if not opened:
        return maps
    truly = [placed.frame_in_map.apply_all(placed.landmarks) for placed in opened]
    turn = rigid_fit(np.concatenate([placed.chained for placed in opened]), np.concatenate(truly)).theta

    def turned(placed: PlacedEdgeMap) -> PlacedEdgeMap:
        theta = wrap(turn + rigid_fit(placed.landmarks, placed.chained).theta)
        return replace(placed, frame_in_map=SE2(placed.frame_in_map.x, placed.frame_in_map.y, theta))

    return [turned(placed) if placed.closed and len(placed.landmarks) else placed for placed in maps]
