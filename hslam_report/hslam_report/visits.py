"""What the true places of a node's visits say: where it is, and whether it is one place at all."""

import math
from collections.abc import Sequence

import networkx as nx

from hslam_report.explored import ExploredGraph, ExploredNode, Visit
from hslam_sim.truth.matching import gate_m
from hslam_types.gvg_events import NodeKind


def places(node: ExploredNode) -> list[list[Visit]]:
    """Return a node's visits grouped by true place, the first visit's group first.

    A visit joins a group if it lies within the matching gate of that group's first visit; more than one group
    means that the atlas took different places for one.
    """
    gate = gate_m(node.clearance_m, boundary=node.kind is NodeKind.BOUNDARY_POINT)
    groups: list[list[Visit]] = []
    for visit in node.visits:
        for group in groups:
            if math.hypot(visit.x - group[0].x, visit.y - group[0].y) <= gate:
                group.append(visit)
                break
        else:
            groups.append([visit])
    return groups


def position(node: ExploredNode) -> tuple[float, float]:
    """Return the mean true place (m, in map) of the visits at the node's first place."""
    group: Sequence[Visit] = places(node)[0]
    return sum(v.x for v in group) / len(group), sum(v.y for v in group) / len(group)


def false_closures(graph: ExploredGraph) -> int:
    """Return how many places were wrongly taken for a node seen elsewhere."""
    return sum(len(places(node)) - 1 for node in graph.nodes)


def true_closures(graph: ExploredGraph) -> int:
    """Return how many loops were rightly closed.

    The first drive along an edge either finds a new node or closes a loop, so loops are the independent cycles.
    """
    joined: nx.MultiGraph[int] = nx.MultiGraph()
    joined.add_nodes_from(node.id for node in graph.nodes)
    joined.add_edges_from((edge.u, edge.v) for edge in graph.edges)
    cycles = len(graph.edges) - len(graph.nodes) + nx.number_connected_components(joined)
    return max(cycles - false_closures(graph), 0)
