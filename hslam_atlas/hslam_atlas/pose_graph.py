"""The global picture: node poses by least squares over all edges, cycles included.

Computed when asked for and never stored.  Nodes are poses, edges and links are measured relations between
them; the start is the concatenation of transforms along shortest chains, since a start from afar ends in a wrong
minimum.  Solved by GTSAM (Levenberg-Marquardt, QR: exactly known directions make the problem nearly singular).
"""

import gtsam
import numpy as np

from hslam_atlas.chain import chained
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.se2 import SE2

_LEAST_STD = 1e-3
"""A relation is trusted to a millimetre and a milliradian at best; an edge's direction is exact by definition."""


def optimised(graph: AtlasGraph, anchor: int) -> dict[int, SE2]:
    """Return every reachable node's pose in the frame of node ``anchor`` (m, rad), in order of distance."""
    start = chained(graph, anchor)
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    factors.addPriorPose2(anchor, gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, _LEAST_STD))
    for node, relation in start.items():
        values.insert(node, gtsam.Pose2(*relation.pose))
    for edge_id in sorted(graph.edges):
        edge = graph.edges[edge_id]
        if edge.ends[0].node in start and edge.ends[0].node != edge.ends[1].node:
            factors.add(_between(edge.ends[0].node, edge.ends[1].node, edge.across(0)))
    for link_id in sorted(graph.links):
        link = graph.links[link_id]
        if link.from_node in start:
            factors.add(_between(link.from_node, link.to_node, link.to_in_from))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setLinearSolverType("MULTIFRONTAL_QR")
    solved = gtsam.LevenbergMarquardtOptimizer(factors, values, parameters).optimize()
    poses = {node: solved.atPose2(node) for node in start}
    return {node: SE2(pose.x(), pose.y(), pose.theta()) for node, pose in poses.items()}


def _between(first: int, second: int, relation: UncertainPose) -> gtsam.BetweenFactorPose2:
    covariance = relation.covariance + np.eye(3) * _LEAST_STD**2
    noise = gtsam.noiseModel.Gaussian.Covariance(covariance)
    return gtsam.BetweenFactorPose2(first, second, gtsam.Pose2(*relation.pose), noise)
