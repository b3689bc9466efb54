"""Where the frames of an atlas truly are in its world, found by laying every edge-map's landmarks over the true ones.

For scoring alone: the robot never reads it.  The oldest node may be any node of the true graph, its frame turned
anyhow: all are tried.  From there edge after edge is laid over the world by itself, so that
nothing the atlas has drifted by gets into the score.
"""

import math
from collections import deque

import numpy as np
from scipy.spatial import KDTree

from hslam_atlas.edge_maps import EdgeMaps
from hslam_atlas.graph import AtlasGraph, Edge
from hslam_bringup.errors import RunError
from hslam_sim.truth.true_gvg import true_gvg
from hslam_sim.world import World
from hslam_types.se2 import SE2, Array

_REACHES_M = (6.0, 12.0, 24.0, 48.0, math.inf)
"""Landmarks this near the node are laid first: a heading wrong by 2 degrees is 2 m at the far end of a long edge."""
_GATES_M = (1.2, 0.8, 0.5, 0.3, 0.3)
"""Landmarks farther than this from any true one have no partner, pass by pass."""
_HEADINGS = tuple(math.radians(10.0 * k) for k in range(36))
"""The way to the first node may turn corners, and the heading drifts on it."""
_FEWEST = 4
_LEAST_SHARE = 0.7


def true_edge_frames(world: World, graph: AtlasGraph, maps: EdgeMaps) -> dict[int, SE2]:
    """Return the true pose in the world of every edge's frame; raises RunError where the atlas is of another world."""
    if not graph.nodes or not len(world.landmarks):
        raise RunError("an atlas without nodes, or a world without landmarks, cannot be scored")
    tree = KDTree(world.landmarks)
    first = min(graph.nodes)
    edges = [edge for edge in graph.edges.values() if first in {end.node for end in edge.ends}]
    nodes = true_gvg(world).nodes
    guesses = [SE2(node.x, node.y, heading) for node in nodes for heading in _HEADINGS]
    shares = [sum(_laid(edge, first, guess, maps, tree)[1] for edge in edges) for guess in guesses]
    if not shares or max(shares) < _LEAST_SHARE * len(edges):
        raise RunError("the atlas does not fit the world: give the --world and --world-seed that it was explored with")
    return _spread(graph, maps, tree, first, guesses[int(np.argmax(shares))])


def _spread(graph: AtlasGraph, maps: EdgeMaps, tree: KDTree, first: int, first_in_world: SE2) -> dict[int, SE2]:
    """Lay edge after edge over the world, outward from a node."""
    frames: dict[int, SE2] = {}
    queue, seen = deque([(first, first_in_world)]), {first}
    while queue:
        node, node_in_world = queue.popleft()
        for branch in graph.nodes[node].ordered():
            if branch.edge is None or branch.edge in frames:
                continue
            edge = graph.edges[branch.edge]
            frames[edge.id] = frame = _laid(edge, node, node_in_world, maps, tree)[0]
            for end, origin in ((0, SE2()), (1, SE2(edge.terminal_x, 0.0, math.pi))):
                there = edge.ends[end]
                if there.node not in seen:
                    seen.add(there.node)
                    queue.append((there.node, frame @ origin @ there.frame_in_node.pose.inverse()))
    return frames


def _laid(edge: Edge, node: int, node_in_world: SE2, maps: EdgeMaps, tree: KDTree) -> tuple[SE2, float]:
    """Return an edge's frame in the world, its landmarks laid over the true ones, and the share that has a partner."""
    end = 0 if edge.ends[0].node == node else 1
    origin = SE2() if end == 0 else SE2(edge.terminal_x, 0.0, math.pi)
    frame = node_in_world @ edge.ends[end].frame_in_node.pose @ origin.inverse()
    points = maps.get(edge.id).landmarks
    if len(points) < _FEWEST:
        return frame, 0.0
    from_node_m = np.hypot(*(points - np.array([origin.x, origin.y])).T)
    for reach_m in _REACHES_M:
        laid = points[from_node_m <= reach_m]
        for gate_m in _GATES_M if len(laid) else ():
            away, index = (np.asarray(found) for found in tree.query(frame.apply_all(laid)))
            near = away < gate_m
            if near.sum() < _FEWEST:
                break
            frame = _best_fit(laid[near], tree.data[index[near]])
    gaps_m = np.asarray(tree.query(frame.apply_all(points))[0])
    return frame, float(np.mean(gaps_m < _GATES_M[-1]))


def _best_fit(points: Array, onto: Array) -> SE2:
    """Return the rigid motion that brings points onto others, by least squares (Arun et al., 1987)."""
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    theta = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    turned = SE2(0.0, 0.0, theta).apply(*points.mean(axis=0).tolist())
    x, y = (onto.mean(axis=0) - np.array(turned)).tolist()
    return SE2(x, y, theta)
