"""A ring of edges with landmark maps whose truth is known: what the global picture is tried on."""

import math
from dataclasses import dataclass

import numpy as np

from hslam_atlas.graph import AtlasGraph, EdgeEnd
from hslam_atlas.store import AtlasStore
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2, Array, rotation

SIDES = 8
LENGTH_M = 20.0
SEEN_M = 6.0
"""Landmarks this far beyond an edge's ends are in its map, too."""


@dataclass(frozen=True, eq=False)
class RingAtlas:
    """An atlas and the truth, in the frame of node 0."""

    graph: AtlasGraph
    maps: AtlasStore
    nodes: list[SE2]
    landmarks: dict[int, Array]
    """By edge, in the order of its map."""


def ring_atlas(seed: int, *, noise_m: float = 0.03, turn_noise: float = 0.01) -> RingAtlas:
    """Return a ring whose edge e leads from node e to node e + 1; the errors of maps and turns are drawn."""
    rng = np.random.default_rng(seed)
    nodes = [SE2()]
    for _ in range(SIDES - 1):
        nodes.append(nodes[-1] @ SE2(LENGTH_M, 0.0, 2.0 * math.pi / SIDES))
    world = np.concatenate(
        [
            node.apply_all(np.column_stack((np.arange(1.0, LENGTH_M, 2.0), rng.choice([-1.3, 1.3], 10))))
            for node in nodes
        ]
    )
    graph, maps, landmarks = AtlasGraph(), AtlasStore(), {}
    for _ in nodes:
        graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0, math.pi - 2.0 * math.pi / SIDES])
    for first, node in enumerate(nodes):
        second = (first + 1) % SIDES
        in_edge = node.inverse().apply_all(world)
        seen = (in_edge[:, 0] > -SEEN_M) & (in_edge[:, 0] < LENGTH_M + SEEN_M) & (np.abs(in_edge[:, 1]) < 8.0)
        landmarks[first] = world[seen]
        edge_map = _drawn(first, in_edge[seen], noise_m, rng)
        error = SE2(0.0, 0.0, float(rng.normal(0.0, turn_noise)))
        back = nodes[second].to(node @ SE2(LENGTH_M, 0.0, math.pi))
        ends = (
            EdgeEnd(first, 0, UncertainPose.diagonal(error, 0.02, turn_noise)),
            EdgeEnd(second, 1, UncertainPose.diagonal(back, 0.02, 0.002)),
        )
        edge = graph.connect(ends, edge_map.terminal_x, float(edge_map.covariance[0, 0]), LENGTH_M, first)
        maps.put(edge.id, edge_map)
    return RingAtlas(graph, maps, nodes, landmarks)


def _drawn(traversal: int, true_in_edge: Array, noise_m: float, rng: np.random.Generator) -> EdgeMap:
    """Return a map whose errors are drawn from its own covariance: a stretch all share, and noise of each."""
    size = 2 + 2 * len(true_in_edge)
    stretch = np.concatenate(([1.0, 0.0], (true_in_edge / LENGTH_M).ravel())) * 3.0 * noise_m
    each = np.diag([0.0, 0.0] + [noise_m**2] * (size - 2))
    covariance = np.outer(stretch, stretch) + each
    error = stretch * rng.normal() + np.sqrt(np.diag(each)) * rng.normal(size=size)
    return EdgeMap(
        traversal=traversal,
        arrival=traversal + 1000,
        terminal_x=LENGTH_M + float(error[0]),
        landmarks=true_in_edge + error[2:].reshape(-1, 2),
        covariance=covariance,
        sightings=(9,) * len(true_in_edge),
        departure_heading=0.0,
        arrival_heading=math.pi,
        robot_at_arrival=SE2(LENGTH_M, 0.0, 0.0),
        path_length_m=LENGTH_M,
    )


def rms_after_fit(picture: Array, truth: Array) -> float:
    """Return the error of points laid on the truth by one rigid motion (m)."""
    a, b = picture - picture.mean(axis=0), truth - truth.mean(axis=0)
    theta = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    return float(np.sqrt((((a @ rotation(theta).T) - b) ** 2).sum(axis=1).mean()))
