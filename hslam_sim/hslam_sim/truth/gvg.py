"""The true reduced GVG as a value."""

import functools
from dataclasses import dataclass
from enum import IntEnum

import networkx as nx

from hslam_sim.truth.matching import gate_m
from hslam_types.se2 import Array


class TrueKind(IntEnum):
    """What a node of the true graph is."""

    MEET_POINT = 1
    BOUNDARY_POINT = 2


@dataclass(frozen=True, slots=True)
class TrueNode:
    """One node, in map."""

    x: float
    y: float
    clearance_m: float
    kind: TrueKind
    branches: tuple[tuple[int, int], ...] = ()
    """The edges that leave it, counter-clockwise, each as (index of the edge, 0 or 1 for which end of it)."""
    core: bool = True
    """Whether it stands in at least 80 % of the variants."""

    @property
    def degree(self) -> int:
        """The number of edges that leave the node; one that returns to it counts twice."""
        return len(self.branches)

    @property
    def is_boundary(self) -> bool:
        """Whether it is a boundary point."""
        return self.kind is TrueKind.BOUNDARY_POINT

    @property
    def gate_m(self) -> float:
        """How far (m) an explored node may lie from it and still be it."""
        return gate_m(self.clearance_m, boundary=self.is_boundary)


@dataclass(frozen=True, slots=True, eq=False)
class TrueEdge:
    """One edge between the nodes of index ``u`` and ``v``."""

    u: int
    v: int
    polyline: Array
    """Points from u to v, n x 2 (m, in map)."""
    length_m: float


@dataclass(frozen=True, eq=False)
class TrueGvg:
    """The reduced GVG of a world."""

    nodes: tuple[TrueNode, ...]
    edges: tuple[TrueEdge, ...]
    only_in_variants: tuple[TrueNode, ...] = ()
    """Nodes that only a variation of the rules or the walls brings about: finding them is no error."""

    @functools.cached_property
    def graph(self) -> "nx.MultiGraph[int]":
        """The nodes (by index, with attributes node and kind) and edges (key: index; attribute length_m)."""
        graph: nx.MultiGraph[int] = nx.MultiGraph()
        for index, node in enumerate(self.nodes):
            graph.add_node(index, node=node, kind=node.kind)
        for index, edge in enumerate(self.edges):
            graph.add_edge(edge.u, edge.v, key=index, length_m=edge.length_m)
        return graph

    @property
    def cycles(self) -> int:
        """The number of independent cycles."""
        return len(self.edges) - len(self.nodes) + nx.number_connected_components(self.graph)

    @property
    def all_core(self) -> bool:
        """Whether the graph is exact: no node of it depends on a threshold or on the walls' noise."""
        return all(node.core for node in self.nodes)

    @functools.cached_property
    def faces(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """The faces of the embedding as the branch ends (edge, end) one leaves nodes by, the face on the left.

        For a connected planar graph nodes - edges + faces = 2 (Euler), which the cyclic orders must satisfy.
        """
        following: dict[tuple[int, int], tuple[int, int]] = {}
        for node in self.nodes:
            for place, (edge, end) in enumerate(node.branches):
                # Arriving along this edge, the next to the right is the one before it counter-clockwise.
                following[edge, 1 - end] = node.branches[place - 1]
        faces: list[tuple[tuple[int, int], ...]] = []
        left = dict.fromkeys(following)
        while left:
            at = first = next(iter(left))
            face: list[tuple[int, int]] = []
            while not face or at != first:
                face.append(at)
                del left[at]
                at = following[at]
            faces.append(tuple(face))
        return tuple(faces)
