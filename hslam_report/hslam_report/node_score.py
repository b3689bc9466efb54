"""Which explored node is which true one: core nodes are matched first, the optional ones excuse the rest."""

from collections.abc import Sequence
from dataclasses import dataclass

from hslam_report.explored import ExploredGraph, ExploredNode
from hslam_report.visits import position
from hslam_sim.truth.gvg import TrueGvg, TrueNode
from hslam_sim.truth.matching import match
from hslam_types.gvg_events import NodeKind


@dataclass(frozen=True)
class NodeMatches:
    """Pairs of explored and true nodes."""

    core: dict[int, int]
    """Explored node's id -> index of the true core node."""
    optional: dict[int, int]
    """Explored node's id -> index of an optional node among the true nodes, or beyond them one only variants have."""
    doubled: tuple[int, ...]
    """Ids of explored nodes that match nothing but lie at a true node another one has: a loop not closed."""


@dataclass(frozen=True, slots=True)
class _Place:
    """An explored node as the matching wants it."""

    x: float
    y: float
    degree: int
    is_boundary: bool


def match_nodes(graph: ExploredGraph, truth: TrueGvg) -> NodeMatches:
    """Return the one-to-one matching of explored nodes with true ones by true place, kind and degree."""
    core_indices = [index for index, node in enumerate(truth.nodes) if node.core]
    every = (*truth.nodes, *truth.only_in_variants)
    others = [index for index, node in enumerate(every) if not node.core]
    core = _matched(graph.nodes, [every[i] for i in core_indices], core_indices)
    rest = [node for node in graph.nodes if node.id not in core]
    optional = _matched(rest, [every[i] for i in others], others)
    left = [node for node in rest if node.id not in optional]
    doubled = _matched(left, list(truth.nodes), list(range(len(truth.nodes))))
    return NodeMatches(core, optional, tuple(sorted(doubled)))


def precision_and_recall(matches: NodeMatches, graph: ExploredGraph, truth: TrueGvg) -> tuple[float, float]:
    """Return (matched / explored, matched core / core); 0 where there is nothing to divide by."""
    core = sum(node.core for node in truth.nodes)
    found = len(matches.core) + len(matches.optional)
    return found / max(len(graph.nodes), 1), len(matches.core) / max(core, 1)


def _matched(nodes: Sequence[ExploredNode], true: list[TrueNode], indices: list[int]) -> dict[int, int]:
    found = [_Place(*position(node), node.degree, node.kind is NodeKind.BOUNDARY_POINT) for node in nodes]
    pairs = match(found, true, [node.gate_m for node in true])
    return {nodes[row].id: indices[column] for row, column in pairs.items()}
