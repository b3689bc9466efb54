"""The hypothesis "this is that node": how well a sight of a node fits a stored one."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

import numpy as np

from hslam_atlas.branches import match_bearings
from hslam_atlas.config import AtlasConfig
from hslam_atlas.edge_maps import EdgeMaps
from hslam_atlas.graph import AtlasGraph, Node
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.map_match import MapMatch, match_constellations
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2, wrap

_POSE_MOST = 6.0
"""No density of a pose is worth more nats: filters are optimistic."""
_POSE_ALONE = 8.0
"""Evidence of pose and exclusion that needs no map to support it."""
_CROWDED_WITHIN = 1.5
"""Multiple of the clearance within which a second node is hardly ever found: the free discs overlap."""
_CROWDED = 0.02
"""Chance of a second node so near: the reduced GVG has hardly any, sensing errs."""
_EXCLUSIVE_M = 0.75
"""No second node was ever found so near, on floors of others by lidar; and none stands within another's free disc."""
_SURE_STDS = 2.0
"""Standard deviations, of a pose already inflated, within which a place must be a node's own to be surely that node."""
_LOOK_ALIKES_TRIED = 3
"""Nodes compared with every arrival to learn how much places look alike."""
_START_SPACING = math.radians(6.0)
"""Spacing of the headings the alignment is started from."""


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A node as an arrival shows it; its frame has the origin at the node and x back to the departure's node."""

    kind: NodeKind
    clearance_m: float
    bearings: tuple[float, ...]
    """Of the branches, in the sight's frame (rad), counter-clockwise."""
    come_along: int
    """Index of the branch the robot came along, -1 if unknown."""
    edge_map: EdgeMap | None
    """The traversal's map seen from this node."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A sight taken for a stored node."""

    node: int
    sight_in_node: UncertainPose
    place_evidence: float
    """Log-odds against "a new node" (nats) by pose, kind, degree and clearance."""
    map_evidence: float | None
    """By the constellation of landmarks, not capped; None without maps."""
    evidence: float
    """Both together, the map's share limited by how often places look alike."""
    branches: tuple[int | None, ...]
    """For each of the sight's branches the node's key."""
    credible: bool
    """Whether some stored constellation matched or, where none speaks against it, the pose leaves no other node."""
    sure: bool = False
    """Whether the chained pose alone puts the sight where no other node can be, and no map contradicts."""


def weigh(
    graph: AtlasGraph,
    maps: EdgeMaps,
    node: Node,
    sight: Sight,
    sight_in_node: UncertainPose,
    look_alikes: LookAlikes,
    config: AtlasConfig,
) -> Hypothesis | None:
    """Weigh one node against the sight whose chained pose in it is given; None where the pose rules it out."""
    pose = _pose_evidence(sight_in_node, _CROWDED_WITHIN * min(node.clearance_m, sight.clearance_m), config)
    if pose is None:
        return None
    match, refined = best_constellation(graph, maps, node, sight, sight_in_node, config)
    place = pose + view_evidence(node, sight)
    evidence = place + look_alikes.joint([match.evidence] if match else [])
    credible = match.agrees if match and match.evidence < 0.0 else pose > _POSE_ALONE or bool(match and match.agrees)
    branches = align_branches(node, sight, refined.pose, config)
    heard = None if match is None else match.evidence
    exclusive_m = min(node.clearance_m, sight.clearance_m)
    sure = node.kind is sight.kind and is_surely_at(sight_in_node, exclusive_m, config)
    sure = sure and (heard is None or heard > config.keep_evidence)
    return Hypothesis(node.id, refined, place, heard, evidence, branches, credible, sure)


def learn_look_alikes(
    graph: AtlasGraph,
    maps: EdgeMaps,
    others: Iterable[tuple[Node, UncertainPose]],
    sight: Sight,
    look_alikes: LookAlikes,
    config: AtlasConfig,
) -> None:
    """Compare a sight with a few nodes it cannot be, as if it were each of them: do different places look alike here?

    ``others``: nodes with the sight's chained pose in them, the nearest first.
    """
    different = ((node, pose) for node, pose in others if node.kind is sight.kind and is_elsewhere(pose, config))
    for node, pose in islice(different, _LOOK_ALIKES_TRIED):
        branch = next((branch for branch in node.ordered() if branch.edge is not None), None)
        if branch is None or branch.edge is None or sight.edge_map is None:
            continue
        edge = graph.edges[branch.edge]
        end = edge.end_at(node.id, branch.key)
        heading = edge.ends[end].frame_in_node.pose.inverse() @ SE2(0.0, 0.0, pose.pose.theta)
        spread = _prior(pose, config)
        stored = maps.seen_from(edge.id, end)
        match = match_constellations(stored, sight.edge_map, SE2(0.0, 0.0, heading.theta), spread, config)
        look_alikes.count(match.evidence)


def align_branches(node: Node, sight: Sight, sight_in_node: SE2, config: AtlasConfig) -> tuple[int | None, ...]:
    """Return, for each branch of the sight, the key of the node's branch it is."""
    bearings = [wrap(bearing + sight_in_node.theta) for bearing in sight.bearings]
    known = [(branch.key, branch.bearing) for branch in node.branches.values()]
    return tuple(match_bearings(bearings, known, config.branch_gate))


def view_evidence(node: Node, sight: Sight) -> float:
    """Weigh kind, degree and clearance: a T may be read as a four-way, a clearance scatters by a few decimetres."""
    if node.kind is not sight.kind:
        return -8.0
    difference = abs(len(node.branches) - len(sight.bearings))
    degree = (0.5, -2.5)[difference] if difference < 2 else -8.0
    return degree + max(-0.5 * ((node.clearance_m - sight.clearance_m) / 0.3) ** 2, -4.0)


def best_constellation(
    graph: AtlasGraph, maps: EdgeMaps, node: Node, sight: Sight, sight_in_node: UncertainPose, config: AtlasConfig
) -> tuple[MapMatch | None, UncertainPose]:
    """Match the sight's landmarks with each edge-map that leaves the node; return the best and the pose it gives."""
    best: MapMatch | None = None
    refined = UncertainPose(SE2(0.0, 0.0, sight_in_node.pose.theta), _prior(sight_in_node, config))
    if sight.edge_map is None:
        return None, refined
    for branch in node.ordered():
        if branch.edge is None:
            continue
        edge = graph.edges[branch.edge]
        end = edge.end_at(node.id, branch.key)
        frame_in_node = edge.ends[end].frame_in_node
        expected = frame_in_node.pose.inverse() @ SE2(0.0, 0.0, sight_in_node.pose.theta)
        spread = _prior(sight_in_node, config)
        for start in _starts(spread[2, 2] ** 0.5):
            prior = SE2(0.0, 0.0, wrap(expected.theta + start))
            match = match_constellations(maps.seen_from(edge.id, end), sight.edge_map, prior, spread, config)
            if best is None or match.evidence > best.evidence:
                best = match
                offset = UncertainPose(match.alignment.offset, match.alignment.offset_covariance)
                refined = UncertainPose.exact(frame_in_node.pose) @ offset
    if best is not None and best.agrees:
        floor = np.diag([config.pair_noise_m**2, config.pair_noise_m**2, config.heading_floor**2])
        return best, UncertainPose(refined.pose, refined.covariance + floor)
    return best, UncertainPose(SE2(0.0, 0.0, sight_in_node.pose.theta), _prior(sight_in_node, config))


def is_where(node: Node, sight_in_node: UncertainPose, config: AtlasConfig) -> bool:
    """Whether a sight lies where a node is, as well as the positions of nodes of its kind repeat."""
    meets = node.kind is NodeKind.MEET_POINT
    repeat_m = config.origin_repeat_m if meets else config.boundary_repeat_m
    spread = sight_in_node.covariance[:2, :2] * config.chain_inflation**2 + 2.0 * repeat_m**2 * np.eye(2)
    position = np.array(sight_in_node.pose[:2])
    return float(position @ np.linalg.solve(spread, position)) < config.pair_gate


def is_elsewhere(place_in_node: UncertainPose, config: AtlasConfig) -> bool:
    """Whether a place can certainly not be a node."""
    return _pose_evidence(place_in_node.inflated(2.0), 0.0, config) is None


def is_surely_at(place_in_node: UncertainPose, exclusive_m: float, config: AtlasConfig) -> bool:
    """Whether a place can only be a node itself: where it lies is known better than the nodes' distance apart.

    ``exclusive_m``: radius of the disc about the node that holds no other, if `_EXCLUSIVE_M` is not less.
    """
    spread = _spread(place_in_node, config)
    position = np.array(place_in_node.pose[:2])
    if float(position @ np.linalg.solve(spread, position)) > config.pair_gate:
        return False
    reach_m = math.hypot(*position) + _SURE_STDS * math.sqrt(float(np.linalg.eigvalsh(spread)[-1]))
    return reach_m < min(max(exclusive_m, 0.5 * _EXCLUSIVE_M), _EXCLUSIVE_M)


def _spread(sight_in_node: UncertainPose, config: AtlasConfig) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the covariance of a chained position, 2 x 2: the filters are optimistic, and both visits scatter."""
    return sight_in_node.covariance[:2, :2] * config.chain_inflation**2 + 2.0 * config.origin_repeat_m**2 * np.eye(2)


def _prior(sight_in_node: UncertainPose, config: AtlasConfig) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the offset's covariance under the hypothesis: the node repeats, the heading is the chain's."""
    heading = max(sight_in_node.heading_std() * config.chain_inflation, 2.0 * config.heading_floor)
    position = 2.0 * config.origin_repeat_m**2
    return np.diag([position, position, min(heading, math.radians(30.0)) ** 2])


def _starts(heading_std: float) -> list[float]:
    """Return the heading offsets (rad) to start from: the further the heading may be off, the more of them."""
    reach = int(min(2.0 * heading_std, math.radians(60.0)) / _START_SPACING)
    return [k * _START_SPACING for k in sorted(range(-reach, reach + 1), key=abs)]


def _pose_evidence(sight_in_node: UncertainPose, crowded_m: float, config: AtlasConfig) -> float | None:
    """Return log of the position's density over that of nodes in general, None beyond the gate.

    Within ``crowded_m`` of a node there is hardly another: where the pose is sure to lie there, that speaks too.
    """
    spread = _spread(sight_in_node, config)
    position = np.array(sight_in_node.pose[:2])
    chi = float(position @ np.linalg.solve(spread, position))
    if chi > config.pose_gate:
        return None
    density = -0.5 * chi - 0.5 * math.log(float(np.linalg.det(spread))) - math.log(2.0 * math.pi)
    room = max(crowded_m - math.hypot(*position), 0.0)
    outside = math.exp(-0.5 * room**2 / float(np.linalg.eigvalsh(spread)[-1]))
    return min(density - math.log(config.node_density), _POSE_MOST) - math.log(_CROWDED + (1.0 - _CROWDED) * outside)
