"""What two atlases have in common: their content, and how far their edge-maps lie apart."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hslam_atlas.store import AtlasStore
from hslam_bringup.errors import RunError


@dataclass(frozen=True)
class Comparison:
    """Atlas ``a`` against atlas ``b``."""

    identical: bool
    """The whole content is the same, bit for bit."""
    nodes: tuple[int, int]
    edges: tuple[int, int]
    landmarks: tuple[int, int]
    edges_in_both: int
    """Edges built from the same drives."""
    length_rms_m: float
    """Of the differences between the lengths of those edges; NaN if there are none."""


def compare(a: Path, b: Path) -> Comparison:
    """Compare two atlas files, or the atlases of two runs' folders.

    Raises RunError if one is missing and StoreError if one is no atlas.
    """
    a, b = (path / "atlas.db" if path.is_dir() else path for path in (a, b))
    for path in (a, b):
        if not path.is_file():
            raise RunError(f"{path}: no such atlas file")
    with AtlasStore.reading(a) as first, AtlasStore.reading(b) as second:
        graphs = first.load()[0], second.load()[0]
        by_drive = [{edge.traversals[0]: edge for edge in graph.edges.values()} for graph in graphs]
        shared = sorted(by_drive[0].keys() & by_drive[1].keys())
        apart = np.array([by_drive[0][drive].terminal_x - by_drive[1][drive].terminal_x for drive in shared])
        landmarks = [
            sum(store.get(edge).size for edge in graph.edges)
            for store, graph in zip((first, second), graphs, strict=True)
        ]
        return Comparison(
            identical=list(first.dump()) == list(second.dump()),
            nodes=(len(graphs[0].nodes), len(graphs[1].nodes)),
            edges=(len(graphs[0].edges), len(graphs[1].edges)),
            landmarks=(landmarks[0], landmarks[1]),
            edges_in_both=len(shared),
            length_rms_m=float(np.sqrt(np.mean(apart**2))) if shared else float("nan"),
        )
