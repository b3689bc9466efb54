"""The global picture by least squares: node poses, edge frames and the landmarks that edge-maps share.

Computed when asked for, never stored, and nothing the robot decides depends on it.  Each edge-map is one factor, with
its full covariance; links and the frames of edges at their nodes are measured relations between poses; landmarks about
a node that two maps share are one point each way.  Solved by GTSAM in two steps: the relations alone, from poses
chained along shortest ways, since a start from afar ends in a wrong minimum; then everything, where what lies far from
all the rest counts little (Cauchy), be it a wrong pair or a wrong link.
"""

import math
from collections.abc import Iterable, Sequence

import gtsam
import numpy as np

from hslam_atlas.chain import chained
from hslam_atlas.config import AtlasConfig
from hslam_atlas.edge_maps import EdgeMaps
from hslam_atlas.graph import AtlasGraph, Edge
from hslam_atlas.local_map_factor import LocalMap, local_map_factor
from hslam_atlas.picture import Picture
from hslam_atlas.shared_landmarks import SharedLandmark, shared_about
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2, Array, rotation

_LEAST_STD = 1e-3
"""A relation is trusted to a millimetre and a milliradian at best; an edge's direction is exact by definition."""
_HUBER, _CAUCHY = 1.345, 3.0
"""Residuals, in standard deviations, from which a relation loses weight."""
_MOST_LANDMARKS = 10**6
"""Of one map: keys of landmarks are counted from the edge's multiple of it."""


def optimised(graph: AtlasGraph, maps: EdgeMaps, anchor: int, config: AtlasConfig | None = None) -> Picture:
    """Return the picture of what is connected with node ``anchor``, in that node's frame."""
    config = config or AtlasConfig()
    chain = chained(graph, anchor)
    edges = [graph.edges[edge] for edge in sorted(graph.edges) if graph.edges[edge].ends[0].node in chain]
    local = {edge.id: as_local_map(maps.get(edge.id)) for edge in edges}
    values = _chained_values({node: pose.pose for node, pose in chain.items()}, edges, local)
    relations = gtsam.noiseModel.mEstimator.Huber.Create(_HUBER)
    factors = _relations(graph, anchor, edges, chain, relations)
    for edge in edges:
        factors.add(local_map_factor(_frame(edge.id), _far(edge.id), (), local[edge.id].marginal(())))
    values = _solved(factors, values)

    shared = [pair for node in chain for pair in shared_about(graph.nodes[node], graph, maps, config)]
    points = _points(shared)
    robust = gtsam.noiseModel.mEstimator.Cauchy.Create(_CAUCHY)
    factors = _relations(graph, anchor, edges, chain, robust)
    for edge in edges:
        known = points.get(edge.id, [])
        keys = [_point(edge.id, landmark) for landmark in known]
        frame = _pose(values, _frame(edge.id))
        for key, place in zip(keys, frame.apply_all(local[edge.id].points[known].reshape(-1, 2)), strict=True):
            values.insert(key, place)
        factors.add(local_map_factor(_frame(edge.id), _far(edge.id), keys, local[edge.id].marginal(known)))
    one_point = gtsam.noiseModel.Robust(robust, gtsam.noiseModel.Isotropic.Sigma(2, config.pair_noise_m))
    for pair in shared:
        ends = _point(pair.edge, pair.landmark), _point(pair.other_edge, pair.other_landmark)
        factors.add(gtsam.BetweenFactorPoint2(*ends, np.zeros(2), one_point))
    values = _solved(factors, values)
    return _picture(chain, local, points, factors, values)


def as_local_map(edge_map: EdgeMap) -> LocalMap:
    """Return an edge-map with the frame at its terminal, x back, as its end."""
    size = 3 + 2 * edge_map.size
    covariance = np.zeros((size, size))
    rows = [0, 1, *range(3, size)]
    covariance[np.ix_(rows, rows)] = edge_map.covariance
    covariance += np.diag([_LEAST_STD**2] * size)
    return LocalMap(SE2(edge_map.terminal_x, 0.0, math.pi), edge_map.landmarks, covariance)


def _chained_values(poses: dict[int, SE2], edges: Iterable[Edge], local: dict[int, LocalMap]) -> gtsam.Values:
    """Return where the chain has nodes and the frames at both ends of every edge."""
    values = gtsam.Values()
    for node, pose in poses.items():
        values.insert(_node(node), gtsam.Pose2(*pose))
    for edge in edges:
        frame = poses[edge.ends[0].node] @ edge.ends[0].frame_in_node.pose
        values.insert(_frame(edge.id), gtsam.Pose2(*frame))
        values.insert(_far(edge.id), gtsam.Pose2(*(frame @ local[edge.id].end)))
    return values


def _relations(
    graph: AtlasGraph,
    anchor: int,
    edges: Iterable[Edge],
    chain: dict[int, UncertainPose],
    loss: gtsam.noiseModel.mEstimator.Base,
) -> gtsam.NonlinearFactorGraph:
    """Return what ties poses alone: the anchor, the frames of edges in their nodes, and links."""
    factors = gtsam.NonlinearFactorGraph()
    factors.addPriorPose2(_node(anchor), gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, _LEAST_STD))
    ties = [
        (_node(end.node), frame(edge.id), end.frame_in_node)
        for edge in edges
        for end, frame in zip(edge.ends, (_frame, _far), strict=True)
    ]
    links = [graph.links[link] for link in sorted(graph.links) if graph.links[link].from_node in chain]
    ties += [(_node(link.from_node), _node(link.to_node), link.to_in_from) for link in links]
    for first, second, relation in ties:
        spread = _turned(relation.covariance, -relation.pose.theta) + np.eye(3) * _LEAST_STD**2
        noise = gtsam.noiseModel.Gaussian.Covariance(spread)
        robust = gtsam.noiseModel.Robust(loss, noise)
        factors.add(gtsam.BetweenFactorPose2(first, second, gtsam.Pose2(*relation.pose), robust))
    return factors


def _points(shared: Sequence[SharedLandmark]) -> dict[int, list[int]]:
    """Return by edge the landmarks of its map that another map has, too."""
    points: dict[int, set[int]] = {}
    for pair in shared:
        points.setdefault(pair.edge, set()).add(pair.landmark)
        points.setdefault(pair.other_edge, set()).add(pair.other_landmark)
    return {edge: sorted(landmarks) for edge, landmarks in points.items()}


def _solved(factors: gtsam.NonlinearFactorGraph, values: gtsam.Values) -> gtsam.Values:
    return gtsam.LevenbergMarquardtOptimizer(factors, values, gtsam.LevenbergMarquardtParams()).optimize()


def _picture(
    chain: dict[int, UncertainPose],
    local: dict[int, LocalMap],
    points: dict[int, list[int]],
    factors: gtsam.NonlinearFactorGraph,
    values: gtsam.Values,
) -> Picture:
    """Return what the solution says; landmarks that only one map has move as their map bends."""
    frames = {edge: _pose(values, _frame(edge)) for edge in local}
    landmarks = {}
    for edge, frame in frames.items():
        known = points.get(edge, [])
        places = np.array([values.atPoint2(_point(edge, landmark)) for landmark in known]).reshape(-1, 2)
        far = frame.to(_pose(values, _far(edge)))
        landmarks[edge] = frame.apply_all(local[edge].conditioned(far, known, frame.inverse().apply_all(places)))
    marginals = gtsam.Marginals(factors, values)
    nodes = {node: _pose(values, _node(node)) for node in chain}
    spreads = {node: _turned(marginals.marginalCovariance(_node(node)), pose.theta) for node, pose in nodes.items()}
    return Picture(nodes, frames, landmarks, spreads)


def _turned(covariance: Array, theta: float) -> Array:
    """Return a pose's covariance by axes turned back by ``theta``.

    GTSAM has it in the pose's own axes, `UncertainPose` in those that the pose is given in.
    """
    turn = np.eye(3)
    turn[:2, :2] = rotation(theta)
    spread: Array = turn @ covariance @ turn.T
    return spread


def _pose(values: gtsam.Values, key: int) -> SE2:
    pose = values.atPose2(key)
    return SE2(pose.x(), pose.y(), pose.theta())


def _node(node: int) -> int:
    return gtsam.symbol("n", node)


def _frame(edge: int) -> int:
    return gtsam.symbol("e", edge)


def _far(edge: int) -> int:
    return gtsam.symbol("f", edge)


def _point(edge: int, landmark: int) -> int:
    return gtsam.symbol("l", edge * _MOST_LANDMARKS + landmark)
