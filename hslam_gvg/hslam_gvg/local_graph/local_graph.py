"""The reduced GVG of what is known round the robot.

The Delaunay dual of the obstacle points gives the ridges; one that leaves what is known ends there, in an exit; what is
left is reduced by the rules that the truth is reduced by.  Unknown space is neither a wall nor free.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay

from hslam_gvg.local_graph import cuts
from hslam_gvg.local_graph import open_space as open_spaces
from hslam_gvg.local_graph.cuts import Indices, IsFree
from hslam_gvg.local_graph.gaps import SHUT, UNKNOWN, Gaps
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.local_graph.open_space import OpenSpace
from hslam_gvg.local_graph.polyline import resampled
from hslam_gvg.voronoi_graph import circumcircles, ridge_clearance, ridges
from hslam_types.se2 import Array
from hslam_voronoi.branch_graph import BranchGraph, Hub
from hslam_voronoi.chains import joined_chains
from hslam_voronoi.reduction import reduce
from hslam_voronoi.rules import ReductionRules

GapsBetween = Callable[[Array, Array], Gaps]

SITES, FAR, FAR_COUNT = 1.2, 3.0, 24
"""Points out to so many horizons shape the graph; a ring of far points, farther out, closes the triangulation."""
DOUBTS = 1.2
"""Gaps within so many clearances of a node lie beside it."""
ACROSS_M = 0.03
"""A ridge whose clearance is hardly more than half the gap of its points goes through that gap, not beside it."""
RULES = ReductionRules()
"""The rules by which the truth is reduced too; nothing else decides what is a node."""


class Way(NamedTuple):
    """One branch as walked from a node."""

    path: Array
    """Points from the node to the other end, k x 3: x, y, clearance (m, odom)."""
    end: int
    """The node at the other end."""


class LocalGraph:
    """Nodes by number; a node is a meet point, a dead end, or an exit into what is not known."""

    def __init__(self, graph: BranchGraph, exits: frozenset[int], doubts: Array) -> None:
        """Take a reduced graph, those of its nodes that are exits, and the middles of gaps nobody knows (n x 2, m)."""
        self._graph, self._exits, self._doubts = graph, exits, doubts
        self._paths = {number: resampled(branch.path) for number, branch in graph.branches.items()}

    def hub(self, number: int) -> Hub:
        """Return a node: its place and clearance (m, odom)."""
        return self._graph.hubs[number]

    def is_exit(self, number: int) -> bool:
        """Whether a node is where the known ends."""
        return number in self._exits

    def is_doubtful(self, number: int) -> bool:
        """Whether a node has a gap beside it of which nobody knows whether it is a way."""
        hub, doubts = self._graph.hubs[number], self._doubts
        return bool((np.hypot(doubts[:, 0] - hub.x, doubts[:, 1] - hub.y) < DOUBTS * hub.clearance).any())

    def degree(self, number: int) -> int:
        """Return how many ways leave a node."""
        return self._graph.degree(number)

    def nodes(self) -> list[int]:
        """Return the meet points and dead ends."""
        return [n for n, hub in self._graph.hubs.items() if n not in self._exits and len(hub.ends) != 2]

    def ways(self, number: int) -> list[Way]:
        """Return the ways that leave a node, counter-clockwise."""
        return [self._way(branch, end) for branch, end in self._graph.hubs[number].ends]

    def paths(self) -> list[tuple[int, Array]]:
        """Return every branch by number, with its path."""
        return list(self._paths.items())

    def ends(self, branch: int) -> tuple[int, int]:
        """Return the nodes at a branch's ends, in the order of its path."""
        joined = self._graph.branches[branch]
        return joined.node(0), joined.node(1)

    def onwards(
        self, branch: int, index: int, forwards: bool, limit_m: float, passed: Callable[[Hub], bool]
    ) -> list[Way]:
        """Return the ways from a point of a branch on in one direction, to the first node that counts.

        Nodes that ``passed`` names, such as the one just left, are gone through, in all directions, up to ``limit_m``.
        """
        path = self._paths[branch]
        walk = path[index:] if forwards else path[: index + 1][::-1]
        found, waiting = [], [(walk, self._graph.branches[branch].node(1 if forwards else 0), {branch})]
        while waiting:
            walk, end, used = waiting.pop()
            hub = self._graph.hubs[end]
            fresh = [(number, side) for number, side in hub.ends if number not in used]
            so_far = float(np.hypot(*np.diff(walk[:, :2], axis=0).T).sum())
            if not fresh or so_far > limit_m or not passed(hub):
                found.append(Way(walk, end))
                continue
            for number, side in fresh:
                beyond = self._way(number, side)
                waiting.append((np.vstack((walk, beyond.path[1:])), beyond.end, used | {number}))
        return found

    def _way(self, branch: int, end: int) -> Way:
        path = self._paths[branch]
        return Way(path if end == 0 else path[::-1], self._graph.branches[branch].node(1 - end))


def local_graph(
    points: Array,
    is_free: IsFree,
    x: float,
    y: float,
    config: LocalGraphConfig,
    gaps: GapsBetween | None = None,
    open_space: OpenSpace = open_spaces.NONE,
) -> LocalGraph | None:
    """Return the part nearest to (x, y) of the graph of obstacle points (n x 2, m, odom); None where there is none.

    ``gaps`` tells what is known of the gaps that ridges go through (their ends: n x 2, n x 2); without it all are open.
    ``open_space`` counts as an obstacle.
    """
    points = np.concatenate((points, open_space.outline))
    clearance = float(np.hypot(points[:, 0] - x, points[:, 1] - y).min(initial=math.inf))
    wanted = max(config.horizon_least_m, config.horizon_clearances * clearance + 2.0)
    horizon = min(config.horizon_m, wanted)
    sites = _sites(points, x, y, horizon, config.site_m)
    mesh = Delaunay(sites)
    centre, radius = circumcircles(sites[mesh.simplices])
    first, second, side = ridges(mesh.simplices, mesh.neighbors)
    begin, end = sites[side[:, 0]], sites[side[:, 1]]
    clear, apart = ridge_clearance(begin, end, centre[first], centre[second])
    # The ends of a side a body cannot pass are one obstacle, unless they are seen far apart: a corner.
    kept = (clear >= config.passable_m) & (apart >= np.minimum(2.0 * config.passable_m, clear))
    doubted = np.zeros(len(kept), bool)
    if gaps is not None:
        across = np.flatnonzero(kept & (clear < 0.5 * apart + ACROSS_M))
        known_of = gaps(begin[across] + (x, y), end[across] + (x, y))
        kept[across] = known_of != SHUT
        doubted[across] = known_of == UNKNOWN
    within = np.einsum("ij,ij->i", centre, centre) < horizon * horizon
    known = within.copy()
    px, py = centre[within, 0] + x, centre[within, 1] + y
    known[within] = is_free(px, py) & ~open_space.holds(px, py)
    kept &= known[first] | known[second]
    if not kept.any():
        return None
    links = np.column_stack((first[kept], second[kept])).astype(np.int64)
    vertices = np.column_stack((centre, radius))
    middle = np.column_stack((0.5 * (begin + end), 0.5 * apart))[kept]
    vertices, links, ends = cuts.in_gaps(vertices, links, known, middle, doubted[kept])
    sites_of = np.concatenate((begin[kept][~doubted[kept]], np.zeros((len(ends), 2))))
    known = np.concatenate((known, np.ones(len(ends), bool)))
    vertices, links, beyond = cuts.at_end_of_free(
        vertices, links, known, sites_of, lambda px, py: is_free(px + x, py + y), config, horizon
    )
    doubts = vertices[list(ends), :2] + (x, y)
    return _reduced(vertices, links, beyond | ends, doubts, x, y, exits_by_ratio=config.exits_by_ratio)


def _sites(points: Array, x: float, y: float, horizon: float, cell_m: float) -> Array:
    """Return obstacle points relative to (x, y), averaged over cells fixed in odom, and the ring of far points."""
    reach = SITES * horizon
    near = points[(np.abs(points[:, 0] - x) < reach) & (np.abs(points[:, 1] - y) < reach)]
    cell = np.floor(near / cell_m).astype(np.int64)
    _, which, count = np.unique(cell[:, 0] * 1_000_003 + cell[:, 1], return_inverse=True, return_counts=True)
    mean = np.column_stack((np.bincount(which, near[:, 0]) / count - x, np.bincount(which, near[:, 1]) / count - y))
    angle = np.arange(FAR_COUNT) * (math.tau / FAR_COUNT)
    return np.concatenate((mean, FAR * horizon * np.column_stack((np.cos(angle), np.sin(angle)))))


def _reduced(
    points: Array,
    links: Indices,
    beyond: dict[int, float],
    doubts: Array,
    x: float,
    y: float,
    *,
    exits_by_ratio: bool,
) -> LocalGraph:
    """Return the reduction of the part that passes nearest to the origin, moved to (x, y)."""
    begin, end = points[links[:, 0], :2], points[links[:, 1], :2]
    along = end - begin
    share = -np.einsum("ij,ij->i", begin, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-12)
    foot = begin + np.clip(share, 0.0, 1.0)[:, None] * along
    nearest = int(np.argmin(np.einsum("ij,ij->i", foot, foot)))
    joined = coo_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(len(points), len(points)))
    part = connected_components(joined, directed=False)[1]
    links = links[part[links[:, 0]] == part[links[nearest, 0]]]
    moved = points + np.array([x, y, 0.0])
    graph = joined_chains(moved, links)
    if not graph.hubs:  # a lone ring: it has no node, and is cut where it begins so that it can be followed
        graph = joined_chains(moved, links, nodes={int(links[0, 0])})
    reduce(graph, RULES, beyond, () if exits_by_ratio else beyond.keys())
    return LocalGraph(graph, frozenset(beyond.keys() & graph.hubs.keys()), doubts)
