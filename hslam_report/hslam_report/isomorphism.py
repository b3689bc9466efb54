"""Whether two embedded graphs are one: same nodes, same edges, same cyclic order at every node.

In a connected graph with a cyclic order at each node, the image of a single branch end fixes the image of
all others.  So the first end of one graph is tried against every end of the other: exact, in quadratic
time, and loops and parallel edges need no special care.
"""

from dataclasses import dataclass

from hslam_report.explored import ExploredGraph
from hslam_sim.truth.gvg import TrueGvg
from hslam_types.gvg_events import NodeKind

End = tuple[int, int]
"""A node's number and the place of a branch in its counter-clockwise order."""


@dataclass(frozen=True)
class Embedding:
    """A graph as cyclic orders: for every node its kind and degree, for every branch end the other end of its edge."""

    is_boundary: dict[int, bool]
    degree: dict[int, int]
    across: dict[End, End]


def embedding_of_explored(graph: ExploredGraph) -> Embedding:
    """Return the embedding of an explored graph; unexplored branches have no other end."""
    across: dict[End, End] = {}
    for edge in graph.edges:
        across[edge.u, edge.branch_u] = (edge.v, edge.branch_v)
        across[edge.v, edge.branch_v] = (edge.u, edge.branch_u)
    boundary = {node.id: node.kind is NodeKind.BOUNDARY_POINT for node in graph.nodes}
    return Embedding(boundary, {node.id: node.degree for node in graph.nodes}, across)


def embedding_of_truth(truth: TrueGvg) -> Embedding:
    """Return the embedding of a true graph."""
    at = {end: (n, place) for n, node in enumerate(truth.nodes) for place, end in enumerate(node.branches)}
    across = {here: at[edge, 1 - side] for (edge, side), here in at.items()}
    boundary = {index: node.is_boundary for index, node in enumerate(truth.nodes)}
    return Embedding(boundary, {index: node.degree for index, node in enumerate(truth.nodes)}, across)


def isomorphism(first: Embedding, second: Embedding) -> dict[int, int] | None:
    """Return nodes of ``first`` -> nodes of ``second`` under which kinds, edges and cyclic orders agree, or None.

    Both must be connected; a graph with an unexplored branch is isomorphic to none.
    """
    if len(first.degree) != len(second.degree) or len(first.across) != len(second.across):
        return None
    if len(first.across) != sum(first.degree.values()) or len(second.across) != sum(second.degree.values()):
        return None
    if not first.across:
        return dict(zip(first.degree, second.degree, strict=True)) if len(first.degree) <= 1 else None
    start = next(iter(first.across))
    for candidate in second.across:
        nodes = _grown(first, second, start, candidate)
        if nodes is not None:
            return nodes
    return None


def _grown(first: Embedding, second: Embedding, start: End, candidate: End) -> dict[int, int] | None:
    """Return the node map that taking ``start`` to ``candidate`` forces, or None if it contradicts itself."""
    # Node of the first graph -> its image, and how many places its order is turned against the image's.
    turned = {start[0]: (candidate[0], candidate[1] - start[1])}
    waiting = [start[0]]
    while waiting:
        node = waiting.pop()
        image, turn = turned[node]
        if first.degree[node] != second.degree[image] or first.is_boundary[node] != second.is_boundary[image]:
            return None
        for place in range(first.degree[node]):
            to, at = first.across[node, place]
            image_to, image_at = second.across[image, (place + turn) % second.degree[image]]
            if to not in turned:
                turned[to] = (image_to, image_at - at)
                waiting.append(to)
            elif turned[to][0] != image_to or (turned[to][1] + at - image_at) % second.degree[image_to] != 0:
                return None
    images = {node: image for node, (image, _) in turned.items()}
    complete = len(images) == len(first.degree) and len(set(images.values())) == len(images)
    return images if complete else None
