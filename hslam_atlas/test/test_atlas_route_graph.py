"""The route graph is one that Nav2 loads: read back here by what its documentation and its loader ask for."""

import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import networkx as nx
import pytest
from ring_atlas import LENGTH_M, SIDES, ring_atlas
from scripted_level import edge_map, row

from hslam_atlas.graph import AtlasGraph, EdgeEnd
from hslam_atlas.networkx_graph import networkx_graph
from hslam_atlas.picture import Picture, composed
from hslam_atlas.route_graph import LARGEST_ID, RouteGraphError, route_graph
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2


class RouteEdge(NamedTuple):
    """A directed edge as the route server keeps it: its geometry is not among it."""

    start: int
    end: int
    cost: float


def loaded(text: str) -> tuple[dict[int, tuple[float, float]], dict[int, RouteEdge]]:
    """Return nodes and edges of a graph file; AssertionError where the loader of `nav2_route` would refuse it."""
    features = json.loads(text)["features"]
    nodes: dict[int, tuple[float, float]] = {}
    edges: dict[int, RouteEdge] = {}
    for feature in features:
        properties, geometry = feature["properties"], feature["geometry"]
        assert isinstance(properties["id"], int)
        assert 0 <= properties["id"] <= 65535
        assert properties["id"] not in nodes.keys() | edges.keys()
        assert all(is_loadable(value) for value in properties.get("metadata", {}).values())
        if geometry["type"] == "Point":
            assert properties["frame"] == "map"
            x, y = geometry["coordinates"]
            nodes[properties["id"]] = (x, y)
        else:
            assert geometry["type"] in ("LineString", "MultiLineString")
            assert properties["cost"] >= 0.0
            edges[properties["id"]] = RouteEdge(properties["startid"], properties["endid"], properties["cost"])
    assert nodes
    assert edges
    assert {end for edge in edges.values() for end in edge[:2]} <= nodes.keys()
    return nodes, edges


def is_loadable(value: Any) -> bool:
    """Whether the loader takes a value of metadata: no null, no array in an array."""
    if isinstance(value, list):
        return all(is_loadable(item) and not isinstance(item, list) for item in value)
    return isinstance(value, str | int | float | bool | Mapping)


def test_it_is_loaded_back_with_every_edge_both_ways() -> None:
    ring = ring_atlas(1)
    picture = composed(ring.graph, ring.maps, 0)
    nodes, edges = loaded(json.dumps(route_graph(ring.graph, picture)))
    assert nodes.keys() == ring.graph.nodes.keys()
    for node, place in nodes.items():
        assert place == pytest.approx(picture.nodes[node][:2], abs=1e-3)
    ways = sorted(edge[:2] for edge in edges.values())
    forth = [(n, (n + 1) % SIDES) for n in range(SIDES)]
    assert ways == sorted(forth + [way[::-1] for way in forth])
    for edge in edges.values():
        assert edge.cost == pytest.approx(math.dist(nodes[edge.start], nodes[edge.end]), abs=2e-3)


def test_a_curved_edge_is_a_string_of_nodes_in_its_order() -> None:
    ring = ring_atlas(1)
    picture = composed(ring.graph, ring.maps, 0)
    bend = [(5.0, -3.0), (15.0, -3.0)]
    nodes, edges = loaded(json.dumps(route_graph(ring.graph, picture, {0: bend})))
    assert len(nodes) == SIDES + 2
    way = nx.DiGraph([edge[:2] for edge in edges.values()])
    first, second = sorted(nodes.keys() - ring.graph.nodes.keys())
    assert [nodes[first], nodes[second]] == bend
    assert not way.has_edge(0, 1)
    assert all(way.has_edge(a, b) and way.has_edge(b, a) for a, b in ((0, first), (first, second), (second, 1)))


def test_what_nav2_would_refuse_is_refused_here() -> None:
    ring = ring_atlas(1)
    picture = composed(ring.graph, ring.maps, 0)
    with pytest.raises(RouteGraphError, match="65535"):
        route_graph(ring.graph, picture, {0: [(0.0, 0.0)] * (LARGEST_ID // 3)})
    lonely = AtlasGraph()
    lonely.add_node(NodeKind.MEET_POINT, 1.0, [0.0])
    with pytest.raises(RouteGraphError, match="without edges"):
        route_graph(lonely, Picture({0: SE2()}, {}, {}, {}))


def test_graphml_keeps_nodes_edges_and_lengths(tmp_path: Any) -> None:
    ring = ring_atlas(1)
    lonely = ring.graph.add_node(NodeKind.BOUNDARY_POINT, 0.7, [0.0, 1.0]).id
    pictures = [composed(ring.graph, ring.maps, anchor) for anchor in (0, lonely)]
    nx.write_graphml(networkx_graph(ring.graph, pictures), tmp_path / "ring.graphml")
    read = nx.read_graphml(tmp_path / "ring.graphml", node_type=int, force_multigraph=True)
    assert read.nodes.keys() == ring.graph.nodes.keys()
    assert sorted(tuple(sorted(pair)) for pair in read.edges()) == sorted(
        tuple(sorted((n, (n + 1) % SIDES))) for n in range(SIDES)
    )
    assert all(data["length_m"] == LENGTH_M for _, _, data in read.edges(data=True))
    assert read.nodes[lonely]["part"] == 1
    assert read.nodes[lonely]["kind"] == "boundary_point"
    assert read.nodes[lonely]["unexplored"] == 2
    assert (read.nodes[1]["x"], read.nodes[1]["y"]) == pytest.approx(pictures[0].nodes[1][:2])


def test_an_edge_of_graphml_tells_the_bearing_at_either_end() -> None:
    state = row()
    network = networkx_graph(state.graph, [composed(state.graph, state.maps, 0)])
    edge = network.edges[1, 2, 1]
    assert (edge["first"], edge["bearing_at_first"], abs(edge["bearing_at_second"])) == (1, 0.0, math.pi)


def test_only_the_part_that_is_pictured_is_given() -> None:
    state = row()
    for _ in range(2):
        state.graph.add_node(NodeKind.MEET_POINT, 1.0, [0.0])
    apart = tuple(EdgeEnd(node, 0, UncertainPose.exact(SE2())) for node in (3, 4))
    state.graph.connect((apart[0], apart[1]), 5.0, 0.0, 5.0, 9)
    state.maps.put(2, edge_map(9, 3))
    found = route_graph(state.graph, composed(state.graph, state.maps, 0))
    edges = {line["properties"]["metadata"].get("atlas_edge") for line in found["features"]}
    assert edges == {None, 0, 1}
