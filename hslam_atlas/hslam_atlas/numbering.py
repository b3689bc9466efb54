"""Numbers of events and drives that no earlier session of the same atlas has used."""

from dataclasses import replace

from hslam_atlas.graph import AtlasGraph
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import GvgEvent


class Numbering:
    """Counts a session's events on from the last the atlas knows, where the GVG level has begun to count anew."""

    def __init__(self, graph: AtlasGraph) -> None:
        """Take the atlas as it is before the session."""
        self._graph = graph
        self._first: int | None = None

    def renew(self) -> None:
        """Be told that the GVG level may begin to count anew."""
        self._first = None

    def event(self, event: GvgEvent) -> GvgEvent:
        """Return an event under its number in the atlas."""
        if self._first is None:
            last = last_number(self._graph)
            self._first = last + 1 if event.sequence <= last else 0
        return replace(event, sequence=event.sequence + self._first) if self._first else event

    def drive(self, traversal: int) -> int:
        """Return a traversal's number in the atlas."""
        return traversal + (self._first or 0)

    def said(self, number: int) -> int:
        """Return the number that the GVG level gave what has a certain one in the atlas."""
        return number - (self._first or 0)

    def edge_map(self, edge_map: EdgeMap) -> EdgeMap:
        """Return an edge-map under its numbers in the atlas."""
        first = self._first
        if not first:
            return edge_map
        return replace(edge_map, traversal=edge_map.traversal + first, arrival=edge_map.arrival + first)

    def link(self, link: FrameLink) -> FrameLink:
        """Return a link under its numbers in the atlas."""
        first = self._first
        return replace(link, traversal=link.traversal + first, departure=link.departure + first) if first else link


def last_number(graph: AtlasGraph) -> int:
    """Return the last number of an event that an atlas knows, -1 without one: every arrival is a visit."""
    visits = (sequence for node in graph.nodes.values() for sequence, _ in node.visits)
    drives = (number for edge in graph.edges.values() for number in edge.traversals)
    return max(max(visits, default=-1), max(drives, default=-1))
