"""From equidistant points and the links between them to a graph of branches."""

from collections.abc import Collection
from typing import Any

import numpy as np
import numpy.typing as npt

from hslam_types.se2 import Array
from hslam_voronoi.branch_graph import BranchGraph

Indices = npt.NDArray[np.signedinteger[Any]]


def joined_chains(points: Array, links: Indices, nodes: Collection[int] = ()) -> BranchGraph:
    """Return the graph whose branches are the chains between points of degree other than two.

    ``points`` are n x 3 (x, y, clearance, m), ``links`` m x 2 pairs of neighbours.  A point in ``nodes`` is a node
    whatever its degree.
    """
    neighbours: dict[int, list[int]] = {}
    for a, b in links.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    graph = BranchGraph()
    for number in sorted(neighbours):
        if len(neighbours[number]) != 2 or number in nodes:
            graph.add_hub(number, *points[number].tolist())
    seen: set[tuple[int, int]] = set()
    for number in list(graph.hubs):
        for first in neighbours[number]:
            if (number, first) in seen:
                continue
            chain = [number, first]
            while chain[-1] not in graph.hubs:
                a, b = neighbours[chain[-1]]
                chain.append(b if a == chain[-2] else a)
            seen.add((chain[-1], chain[-2]))
            graph.add_branch(chain[0], chain[-1], points[chain])
    graph.order_ends()
    return graph
