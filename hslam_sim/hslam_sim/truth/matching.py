"""One-to-one matching of nodes by place: the Hungarian method under a gate that grows with clearance."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from scipy.optimize import linear_sum_assignment

GATE_M = 1.0
BOUNDARY_GATE_M = 1.5
DEGREE_COST = 0.2
NEVER = 1e6


class Place(Protocol):
    """What matching needs of a node."""

    @property
    def x(self) -> float:
        """Position in map (m)."""

    @property
    def y(self) -> float:
        """Position in map (m)."""

    @property
    def degree(self) -> int:
        """The number of edges that leave."""

    @property
    def is_boundary(self) -> bool:
        """Whether it is a boundary point; such a node only matches another."""


def gate_m(clearance_m: float, *, boundary: bool) -> float:
    """Return how far (m) a node may lie from the true one it is."""
    return max(BOUNDARY_GATE_M if boundary else GATE_M, clearance_m)


def match(found: Sequence[Place], true: Sequence[Place], gates_m: Sequence[float]) -> dict[int, int]:
    """Return pairs (index found -> index true) of least total cost; ``gates_m`` belongs to ``true``.

    The cost is distance / gate, plus 0.2 where the degrees differ; pairs beyond the gate are never made.
    """
    if not found or not true:
        return {}
    cost = np.full((len(found), len(true)), NEVER)
    there = np.array([(node.x, node.y) for node in true])
    gates = np.asarray(gates_m)
    degrees = np.array([node.degree for node in true])
    boundary = np.array([node.is_boundary for node in true])
    for row, node in enumerate(found):
        distance = np.hypot(there[:, 0] - node.x, there[:, 1] - node.y)
        near = (distance <= gates) & (boundary == node.is_boundary)
        cost[row, near] = (distance / gates + DEGREE_COST * (degrees != node.degree))[near]
    rows, columns = linear_sum_assignment(cost)
    return {int(r): int(c) for r, c in zip(rows, columns, strict=True) if cost[r, c] < NEVER}
