"""From the raw skeleton to the reduced GVG: wide places become one node, then the rules that the robot shares apply."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hslam_sim.truth.rules import Rules
from hslam_sim.truth.skeleton import Indices, Skeleton
from hslam_types.se2 import Array
from hslam_voronoi.branch_graph import BranchGraph
from hslam_voronoi.chains import joined_chains
from hslam_voronoi.reduction import reduce


def reduced(raw: Skeleton, rules: Rules) -> BranchGraph:
    """Return the reduced GVG of a skeleton; the ends that are left with one branch are boundary points."""
    graph = joined_chains(*_open_places_joined(raw, rules.open_m))
    reduce(graph, rules)
    return graph


def _open_places_joined(raw: Skeleton, open_m: float) -> tuple[Array, Indices, set[int]]:
    """Return points, links and the points that stand for open places, each connected open part made one point.

    The branches of such a node begin at its contour of clearance ``open_m``, with that clearance.
    """
    inside = raw.points[:, 2] > open_m
    both = inside[raw.links].all(axis=1)
    n = len(raw.points)
    within = raw.links[both]
    joined = coo_matrix((np.ones(len(within)), (within[:, 0], within[:, 1])), shape=(n, n))
    _, labels = connected_components(joined, directed=False)
    centre = np.arange(n)
    points = raw.points.copy()
    for label in np.unique(labels[inside]):
        members = np.flatnonzero((labels == label) & inside)
        centre[members] = members[np.argmax(raw.points[members, 2])]
    points[inside, 2] = open_m
    links = centre[raw.links]
    return points, links[links[:, 0] != links[:, 1]], {int(c) for c in np.unique(centre[inside])}
