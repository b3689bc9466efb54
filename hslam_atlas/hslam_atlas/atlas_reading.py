"""An atlas for programs of one's own: opened to read, planned in, looked into.  `docs/python_api.md` shows how."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hslam_atlas.errors import AtlasError
from hslam_atlas.graph import AtlasGraph, Edge, Node
from hslam_atlas.localisation.by_sightings import SightedPlace, beyond_doubt, places_of
from hslam_atlas.picture import Picture, parts
from hslam_atlas.routes import outward
from hslam_atlas.store import AtlasStore
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import Array


class NoSuchPlaceError(AtlasError):
    """An id the atlas does not have, or a node no way leads to; the text says which."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The shortest way from one node to another, stops at nodes counted as the robot counts them."""

    nodes: tuple[int, ...]
    """From the start to the goal, both included."""
    edges: tuple[int, ...]
    """Between them: one fewer."""
    length_m: float


class OpenAtlas:
    """What an atlas file knows; nothing in it is changed, whoever writes it meanwhile."""

    def __init__(self, store: AtlasStore) -> None:
        """Read the graph; maps are read when they are asked for."""
        self._store = store
        self._graph: AtlasGraph = store.load()[0]
        self._pictures: dict[int, Picture] = {}

    @property
    def nodes(self) -> dict[int, Node]:
        """The nodes by id."""
        return self._graph.nodes

    @property
    def edges(self) -> dict[int, Edge]:
        """The edges by id."""
        return self._graph.edges

    @property
    def parts(self) -> list[list[int]]:
        """The ids of the nodes of each connected part, the largest first."""
        return parts(self._graph)

    def edge_map(self, edge: int) -> EdgeMap:
        """Return an edge's map: ``landmarks`` (n x 2, m, in the edge's frame), ``covariance`` and the rest."""
        if edge not in self._graph.edges:
            raise NoSuchPlaceError(f"the atlas has no edge {edge}")
        return self._store.get(edge)

    def picture(self, anchor: int | None = None) -> Picture:
        """Return nodes, edge frames and landmarks of a connected part in the frame of one of its nodes.

        By least squares, in a second or two for a floor; ``anchor``: that node, the oldest of the largest part if
        not given.
        """
        from hslam_atlas.pose_graph import optimised  # noqa: PLC0415 - GTSAM: whoever only plans does without

        anchor = self._first() if anchor is None else self._known(anchor)
        if anchor not in self._pictures:
            self._pictures[anchor] = optimised(self._graph, self._store, anchor)
        return self._pictures[anchor]

    def plan(self, start: int, goal: int) -> Plan:
        """Return the shortest way along known edges; raises NoSuchPlaceError where there is none."""
        nodes, edges, length_m = [self._known(start)], list[int](), 0.0
        self._known(goal)
        while nodes[-1] != goal:
            here = nodes[-1]
            there = next(
                (r for r in outward(self._graph, here, self._graph.nodes[here].branches) if r.node == goal), None
            )
            if there is None:
                raise NoSuchPlaceError(f"no way along known edges leads from node {start} to node {goal}")
            edge = self._graph.edges[self._edge_of(here, there.first)]
            edges.append(edge.id)
            length_m += edge.path_length_m
            nodes.append(edge.ends[1 - edge.end_at(here, there.first)].node)
        return Plan(tuple(nodes), tuple(edges), length_m)

    def places(self, look: Array, gate_m: float = 0.15) -> list[SightedPlace]:
        """Return where one look at landmarks (n x 2, m, in base_link) may have been taken, the likeliest first.

        ``gate_m``: how far off a landmark of the look may be.
        """
        return places_of(look, sorted(self._graph.edges), self._store, gate_m)

    def localise(self, look: Array, gate_m: float = 0.15) -> SightedPlace | None:
        """Return where a look was taken, arguments as for `places`; None where that is in doubt: look again."""
        places = self.places(look, gate_m)
        if not places:
            return None
        picture = self.picture(self._graph.edges[places[0].edge].ends[0].node)
        one_part = [place for place in places if place.edge in picture.edge_frames]
        if any(place.edge not in picture.edge_frames and place.matched == places[0].matched for place in places):
            return None
        return beyond_doubt(one_part, picture.edge_frames, len(look))

    def _edge_of(self, node: int, branch: int) -> int:
        edge = self._graph.nodes[node].branches[branch].edge
        if edge is None:
            raise NoSuchPlaceError(f"branch {branch} of node {node} is unexplored")
        return edge

    def _known(self, node: int) -> int:
        if node not in self._graph.nodes:
            raise NoSuchPlaceError(f"the atlas has no node {node}")
        return node

    def _first(self) -> int:
        if not self._graph.nodes:
            raise NoSuchPlaceError("the atlas is empty")
        return self.parts[0][0]


@contextmanager
def open_atlas(path: Path | str) -> Iterator[OpenAtlas]:
    """Open an atlas file to read; raises StoreError (one line that says what is wrong) where it is none."""
    with AtlasStore.reading(Path(path)) as store:
        yield OpenAtlas(store)
