"""Where edge-maps are kept: one map an edge, seen from either end."""

from typing import Protocol

from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse


class EdgeMaps(Protocol):
    """The maps of an atlas by edge id."""

    def get(self, edge_id: int) -> EdgeMap:
        """Return the stored map, in the frame of the edge's first end."""
        ...

    def seen_from(self, edge_id: int, end: int) -> EdgeMap:
        """Return the map with its origin at the given end."""
        ...

    def put(self, edge_id: int, edge_map: EdgeMap) -> None:
        """Store or replace an edge's map."""
        ...

    def drop(self, edge_id: int) -> None:
        """Forget an edge's map."""
        ...


class MapsInMemory:
    """All maps in memory, the reversed ones made when first asked for."""

    def __init__(self) -> None:
        """Start empty."""
        self._maps: dict[int, EdgeMap] = {}
        self._reversed: dict[int, EdgeMap] = {}

    def get(self, edge_id: int) -> EdgeMap:
        """Return the stored map, in the frame of the edge's first end."""
        return self._maps[edge_id]

    def seen_from(self, edge_id: int, end: int) -> EdgeMap:
        """Return the map with its origin at the given end."""
        if end == 0:
            return self._maps[edge_id]
        if edge_id not in self._reversed:
            self._reversed[edge_id] = reverse(self._maps[edge_id])
        return self._reversed[edge_id]

    def put(self, edge_id: int, edge_map: EdgeMap) -> None:
        """Store or replace an edge's map."""
        self._maps[edge_id] = edge_map
        self._reversed.pop(edge_id, None)

    def drop(self, edge_id: int) -> None:
        """Forget an edge's map."""
        self._maps.pop(edge_id, None)
        self._reversed.pop(edge_id, None)
