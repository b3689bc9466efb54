"""What the atlas needs of whatever keeps its edge-maps."""

from typing import Protocol

from hslam_types.edge_map import EdgeMap


class EdgeMaps(Protocol):
    """The maps of an atlas by edge id: one an edge, seen from either end."""

    def get(self, edge_id: int) -> EdgeMap:
        """Return the stored map, in the frame of the edge's first end."""
        ...

    def seen_from(self, edge_id: int, end: int) -> EdgeMap:
        """Return the map with its origin at the given end (0 or 1)."""
        ...

    def put(self, edge_id: int, edge_map: EdgeMap) -> None:
        """Store or replace an edge's map."""
        ...

    def drop(self, edge_id: int) -> None:
        """Forget an edge's map."""
        ...
