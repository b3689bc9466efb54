"""What is in an atlas file, in figures."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from hslam_atlas.explore import unexplored
from hslam_atlas.picture import parts
from hslam_atlas.store import AtlasStore
from hslam_types.gvg_events import NodeKind


@dataclass(frozen=True)
class AtlasInfo:
    """Counts and lengths; lengths are those that were driven."""

    size_mb: float
    nodes: int
    boundary_points: int
    edges: int
    links: int
    """Metric relations that are no edges."""
    parts: int
    """That no edge or link connects."""
    unexplored: int
    """Branches nobody has driven along."""
    open_questions: int
    """Pairs of nodes that may be one."""
    drives: int
    """In all edge-maps."""
    landmarks: int
    length_m: float
    """Of all edges."""
    shortest_edge_m: float
    longest_edge_m: float

    @property
    def fields(self) -> dict[str, Any]:
        """The fields of the report."""
        return asdict(self)


def atlas_info(path: Path) -> AtlasInfo:
    """Read an atlas; raises StoreError where that cannot be."""
    with AtlasStore.reading(path) as store:
        graph, questions = store.load()
        landmarks = sum(store.get(edge).size for edge in graph.edges)
    divided, lengths = parts(graph), [edge.path_length_m for edge in graph.edges.values()]
    return AtlasInfo(
        size_mb=round(path.stat().st_size / 1e6, 3),
        nodes=len(graph.nodes),
        boundary_points=sum(node.kind is NodeKind.BOUNDARY_POINT for node in graph.nodes.values()),
        edges=len(graph.edges),
        links=len(graph.links),
        parts=len(divided),
        unexplored=unexplored(graph),
        open_questions=len(questions),
        drives=sum(len(edge.traversals) for edge in graph.edges.values()),
        landmarks=landmarks,
        length_m=sum(lengths),
        shortest_edge_m=min(lengths, default=0.0),
        longest_edge_m=max(lengths, default=0.0),
    )
