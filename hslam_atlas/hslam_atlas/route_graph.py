"""An atlas as the route graph of Nav2 (`nav2_route`, GeoJSON).

What that loader asks for (Jazzy): a file of at least one node and one edge, ids that fit 16 bits and are unique over
nodes and edges together, edges of one direction each, metadata without nulls and nested arrays.  It ignores
the geometry of an edge and drives straight from node to node, so that a curved edge is given as a string of nodes.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

from hslam_atlas.errors import AtlasError
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.picture import Picture

LARGEST_ID = 2**16 - 1
"""Nav2 keeps ids in 16 bits."""
_DIGITS = 3
"""After the point: millimetres."""


class RouteGraphError(AtlasError):
    """An atlas makes no route graph that Nav2 would load; the text says why."""


def route_graph(
    graph: AtlasGraph, picture: Picture, bends: Mapping[int, Sequence[tuple[float, float]]] | None = None
) -> dict[str, Any]:
    """Return a FeatureCollection of the part of an atlas that a picture shows.

    ``bends``: by edge, points between its ends (m, in the picture), from its first end on; without them it is straight.
    Node ids are those of the atlas where they fit; the nodes of bends follow, then edges, one for each direction.
    Raises RouteGraphError where there is no edge, or more than the ids can tell apart.
    """
    bends = bends or {}
    edges = [graph.edges[edge] for edge in sorted(graph.edges) if edge in picture.edge_frames]
    if not edges:
        raise RouteGraphError("an atlas without edges makes no route graph; explore a floor first")
    points = [
        _point(node, pose[:2], graph.nodes[node].kind.name.lower()) for node, pose in sorted(picture.nodes.items())
    ]
    places = {node: pose[:2] for node, pose in picture.nodes.items()}
    counter = itertools.count(max(picture.nodes) + 1)
    ways = []
    for edge in edges:
        stations = [edge.ends[0].node]
        for place in bends.get(edge.id, ()):
            stations.append(next(counter))
            places[stations[-1]] = place
            points.append(_point(stations[-1], place, "bend"))
        ways.append((edge, [*stations, edge.ends[1].node]))
    lines = [
        _line(next(counter), start, end, places, edge.id)
        for edge, stations in ways
        for forth in itertools.pairwise(stations)
        for start, end in (forth, forth[::-1])
    ]
    if (most := next(counter) - 1) > LARGEST_ID:
        raise RouteGraphError(f"the route graph needs ids up to {most}, Nav2 knows them up to {LARGEST_ID}")
    return {
        "type": "FeatureCollection",
        "name": "hslam_atlas",
        "features": [*points, *lines],
    }


def _point(number: int, place: tuple[float, float], kind: str) -> dict[str, Any]:
    coordinates = [round(place[0], _DIGITS), round(place[1], _DIGITS)]
    return {
        "type": "Feature",
        "properties": {"id": number, "frame": "map", "metadata": {"class": kind}},
        "geometry": {"type": "Point", "coordinates": coordinates},
    }


def _line(number: int, start: int, end: int, places: Mapping[int, tuple[float, float]], edge: int) -> dict[str, Any]:
    ends = [[round(x, _DIGITS), round(y, _DIGITS)] for x, y in (places[start], places[end])]
    return {
        "type": "Feature",
        "properties": {
            "id": number,
            "startid": start,
            "endid": end,
            "cost": round(math.dist(*ends), _DIGITS),
            "overridable": True,
            "metadata": {"atlas_edge": edge},
        },
        "geometry": {"type": "MultiLineString", "coordinates": [ends]},
    }
