"""The optimised picture is exact without noise, better than the chain with it, and not led astray by what is wrong."""

import math

import numpy as np
import pytest
from ring_atlas import LENGTH_M, SIDES, RingAtlas, ring_atlas, rms_after_fit

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.picture import Picture, composed, parts
from hslam_atlas.pose_graph import optimised
from hslam_atlas.shared_landmarks import shared_about
from hslam_atlas.store import AtlasStore
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2, wrap

LINKS = 12


def ring_of_links(noise_m: float, noise_rad: float, seed: int) -> tuple[AtlasGraph, list[SE2]]:
    """Return a ring of nodes tied by measured links alone, and the nodes' true poses in the first one's frame."""
    rng = np.random.default_rng(seed)
    step = SE2(10.0, 0.0, 2.0 * math.pi / LINKS)
    truth = [SE2()]
    for _ in range(LINKS - 1):
        truth.append(truth[-1] @ step)
    graph = AtlasGraph()
    for _ in truth:
        graph.add_node(NodeKind.MEET_POINT, 1.0, [0.0])
    for i in range(LINKS):
        error = SE2(*(rng.normal(size=3) * [noise_m, noise_m, noise_rad]).tolist())
        graph.add_link(i, (i + 1) % LINKS, UncertainPose.diagonal(step @ error, noise_m, noise_rad), 10.0)
    return graph, truth


def node_rms(picture: Picture, truth: list[SE2]) -> float:
    """Return the root mean square position error (m)."""
    return math.sqrt(sum(math.dist(p[:2], truth[n][:2]) ** 2 for n, p in picture.nodes.items()) / len(truth))


def landmark_rms(picture: Picture, ring: RingAtlas) -> float:
    """Return the error of all maps' landmarks, laid on the truth (m)."""
    edges = sorted(ring.landmarks)
    return rms_after_fit(
        np.concatenate([picture.landmarks[edge] for edge in edges]),
        np.concatenate([ring.landmarks[edge] for edge in edges]),
    )


def test_without_noise_links_are_the_truth() -> None:
    graph, truth = ring_of_links(0.0, 0.0, seed=1)
    picture = optimised(graph, AtlasStore(), 0)
    assert node_rms(picture, truth) < 1e-6
    assert all(abs(wrap(pose.theta - truth[node].theta)) < 1e-6 for node, pose in picture.nodes.items())


def test_a_cycle_of_links_makes_it_better_than_the_chain() -> None:
    better = []
    for seed in range(10):
        graph, truth = ring_of_links(0.05, 0.02, seed)
        chain, picture = (picture_of(graph, AtlasStore(), 0) for picture_of in (composed, optimised))
        better.append(node_rms(picture, truth) < node_rms(chain, truth))
    assert sum(better) >= 8


def test_another_anchor_gives_the_same_shape() -> None:
    ring = ring_atlas(3)
    at_zero, at_five = (optimised(ring.graph, ring.maps, anchor).nodes for anchor in (0, 5))
    for node, pose in at_five.items():
        moved = at_zero[5].to(at_zero[node])
        assert (moved.x, moved.y) == pytest.approx((pose.x, pose.y), abs=5e-3)


def test_without_noise_edges_and_landmarks_are_the_truth() -> None:
    ring = ring_atlas(1, noise_m=0.0, turn_noise=0.0)
    picture = optimised(ring.graph, ring.maps, 0)
    assert node_rms(picture, ring.nodes) < 1e-3
    assert landmark_rms(picture, ring) < 1e-3
    for edge, frame in picture.edge_frames.items():
        assert math.dist(frame[:2], ring.nodes[edge][:2]) < 2e-3


@pytest.mark.parametrize("seed", range(5))
def test_shared_landmarks_make_it_better_than_the_cycle_alone(seed: int) -> None:
    ring = ring_atlas(seed)
    apart = optimised(ring.graph, ring.maps, 0, AtlasConfig(pair_gate=1.0, pair_noise_m=0.001))  # hardly a pair
    shared = optimised(ring.graph, ring.maps, 0)
    assert landmark_rms(shared, ring) < 0.6 * landmark_rms(composed(ring.graph, ring.maps, 0), ring)
    assert landmark_rms(shared, ring) < landmark_rms(apart, ring)
    assert landmark_rms(shared, ring) < 0.09


def test_landmarks_about_a_node_are_paired_with_themselves() -> None:
    ring = ring_atlas(2)
    pairs = [
        pair for node in ring.graph.nodes.values() for pair in shared_about(node, ring.graph, ring.maps, AtlasConfig())
    ]
    assert len(pairs) >= 3 * SIDES
    for pair in pairs:
        one, other = ring.landmarks[pair.edge][pair.landmark], ring.landmarks[pair.other_edge][pair.other_landmark]
        assert tuple(one) == pytest.approx(tuple(other))


def test_a_link_that_is_wrong_moves_nothing() -> None:
    ring = ring_atlas(4)
    before = landmark_rms(optimised(ring.graph, ring.maps, 0), ring)
    true = ring.nodes[1].to(ring.nodes[5])
    ring.graph.add_link(1, 5, UncertainPose.diagonal(true @ SE2(0.0, 6.0, 0.5), 0.05, 0.01), 60.0)
    assert landmark_rms(optimised(ring.graph, ring.maps, 0), ring) == pytest.approx(before, abs=0.01)


def test_the_spread_of_nodes_grows_away_from_the_anchor_and_holds_their_errors() -> None:
    chi = []
    for seed in range(8):
        ring = ring_atlas(seed)
        picture = optimised(ring.graph, ring.maps, 0)
        off = np.array(picture.nodes[SIDES // 2][:2]) - ring.nodes[SIDES // 2][:2]
        spread = picture.node_covariances[SIDES // 2][:2, :2]
        assert np.trace(picture.node_covariances[1][:2, :2]) < np.trace(spread)
        chi.append(float(off @ np.linalg.solve(spread, off)))
    assert 0.3 < np.mean(chi) / 2.0 < 3.0


def test_parts_that_nothing_connects_are_told_apart() -> None:
    ring = ring_atlas(1)
    lonely = ring.graph.add_node(NodeKind.BOUNDARY_POINT, 1.0, [0.0]).id
    assert parts(ring.graph) == [list(range(SIDES)), [lonely]]
    assert list(optimised(ring.graph, ring.maps, lonely).nodes) == [lonely]
    assert lonely not in optimised(ring.graph, ring.maps, 0).nodes


def test_the_chain_is_what_its_edges_say() -> None:
    ring = ring_atlas(1, noise_m=0.0, turn_noise=0.0)
    chain = composed(ring.graph, ring.maps, 0)
    assert chain.nodes[1][:2] == pytest.approx((LENGTH_M, 0.0), abs=1e-9)
    assert landmark_rms(chain, ring) < 1e-9


def test_a_relation_is_as_uncertain_as_it_is_by_the_axes_of_the_node_it_leads_from() -> None:
    """20 cm along x, 5 cm across, to nodes that face elsewhere; where nothing closes the picture is the chain."""
    graph = AtlasGraph()
    for _ in range(3):
        graph.add_node(NodeKind.MEET_POINT, 1.0, [0.0])
    spread = np.diag([0.04, 0.0025, 0.0004])
    graph.add_link(0, 1, UncertainPose(SE2(10.0, 0.0, 0.5 * math.pi), spread), 10.0)
    graph.add_link(1, 2, UncertainPose(SE2(5.0, 2.0, -0.8), spread), 5.0)
    chain, picture = (make(graph, AtlasStore(), 0).node_covariances for make in (composed, optimised))
    for node in (1, 2):
        assert picture[node] == pytest.approx(chain[node], abs=2e-4)
