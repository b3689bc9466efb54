"""The edge-maps of an atlas file: read when asked for, few kept in memory, what is new held until the next save."""

from abc import ABC, abstractmethod
from collections import OrderedDict

from hslam_atlas import edge_map_blob
from hslam_atlas.errors import StoreError
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse

_KEPT = 64
"""Maps held in memory: some 20 MB of a hundred landmarks each."""


class StoredMaps(ABC):
    """One map an edge, seen from either end (`EdgeMaps`)."""

    def __init__(self) -> None:
        """Start with nothing read and nothing to write."""
        self._cache: OrderedDict[tuple[int, int], EdgeMap] = OrderedDict()
        self._unsaved: dict[int, bytes | None] = {}
        """By edge: the map to be written, None to be taken out."""

    def get(self, edge_id: int) -> EdgeMap:
        """Return the stored map, in the frame of the edge's first end; raises StoreError if there is none."""
        return self.seen_from(edge_id, 0)

    def seen_from(self, edge_id: int, end: int) -> EdgeMap:
        """Return the map with its origin at the given end (0 or 1); raises StoreError if there is none."""
        known = self._cache.get((edge_id, end))
        if known is None:
            known = reverse(self.seen_from(edge_id, 0)) if end else self._decoded(edge_id)
            self._keep(edge_id, end, known)
        self._cache.move_to_end((edge_id, end))
        return known

    def put(self, edge_id: int, edge_map: EdgeMap) -> None:
        """Store or replace an edge's map, with the next save."""
        self._unsaved[edge_id] = edge_map_blob.encode(edge_map)
        self._cache.pop((edge_id, 1), None)
        self._keep(edge_id, 0, edge_map)

    def drop(self, edge_id: int) -> None:
        """Forget an edge's map, with the next save."""
        self._unsaved[edge_id] = None
        for end in (0, 1):
            self._cache.pop((edge_id, end), None)

    @abstractmethod
    def _read_map(self, edge_id: int) -> EdgeMap | None:
        """Return an edge's map as it is in the file, None if there is none; raises StoreError."""

    def _decoded(self, edge_id: int) -> EdgeMap:
        if edge_id in self._unsaved:
            blob = self._unsaved[edge_id]
            found = None if blob is None else edge_map_blob.decode(blob)
        else:
            found = self._read_map(edge_id)
        if found is None:
            raise StoreError(f"edge {edge_id} has no map")
        return found

    def _keep(self, edge_id: int, end: int, edge_map: EdgeMap) -> None:
        self._cache[edge_id, end] = edge_map
        while len(self._cache) > _KEPT:
            self._cache.popitem(last=False)
