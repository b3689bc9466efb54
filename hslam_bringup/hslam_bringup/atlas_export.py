"""What an atlas is given to others as: a route graph, GraphML, a map, a trajectory."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import networkx as nx
import shapely

from hslam_atlas.graph import AtlasGraph
from hslam_atlas.networkx_graph import networkx_graph
from hslam_atlas.picture import Picture, parts
from hslam_atlas.pose_graph import optimised
from hslam_atlas.route_graph import route_graph
from hslam_atlas.state import AtlasState
from hslam_bringup.driven_way import DrivenWay, PlacedStation
from hslam_bringup.errors import RunError
from hslam_bringup.occupancy import occupancy
from hslam_ros.stamps import NS_PER_S

Show = Callable[[float], None]
_STRAIGHTER_M = 0.25
"""A route keeps this near to the way that was driven."""
_AGAIN_M = 0.3
"""Two places nearer than this are one."""
_BODY_RADIUS_M = 0.25
_CURVED = 1.05
"""An edge this much longer than the distance of its nodes is no straight line."""


@dataclass(frozen=True)
class Exported:
    """What was written, in words for a person."""

    path: Path
    said: str


def export(state: AtlasState, to: str, out: Path, bag: Path | None, cell_m: float, show: Show) -> Exported:
    """Write an atlas in one of the formats; raises RunError or RouteGraphError where that cannot be.

    A floor known in parts that nothing connects: the largest is written, but for GraphML, which has all.
    """
    divided = parts(state.graph)
    if to == "graphml":
        pictures = [optimised(state.graph, state.maps, part[0], state.config) for part in divided]
        network = networkx_graph(state.graph, pictures)
        nx.write_graphml(network, out)
        return Exported(out, f"{len(network.nodes)} nodes, {len(network.edges)} edges")
    picture = optimised(state.graph, state.maps, divided[0][0], state.config)
    left_out = f"; {len(divided) - 1} smaller parts are left out" if len(divided) > 1 else ""
    stations = [] if bag is None else DrivenWay(bag, with_ranges=to == "map", show=show).placed(state.graph, picture)
    if to == "geojson":
        found = route_graph(state.graph, picture, bends(state.graph, picture, stations))
        out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        curved = [
            edge for edge in picture.edge_frames
            if state.graph.edges[edge].path_length_m > _CURVED * state.graph.edges[edge].terminal_x
        ]  # fmt: skip
        straight = f"; {len(curved)} curved edges are drawn straight (a run's --bag tells their ways)"
        said = f"{len(found['features'])} features{straight if curved and bag is None else ''}"
    elif bag is None:
        raise RunError(f"--to {to} asks for the way that was driven, which only the run's bag holds: add --bag BAG")
    elif to == "map":
        grid = occupancy(stations, cell_m, _BODY_RADIUS_M)
        said = f"{grid.grey.shape[1]} x {grid.grey.shape[0]} cells in {grid.write(out).name}"
    else:
        out.write_text("".join(map(tum_line, stations)), encoding="utf-8")
        said = f"{len(stations)} poses"
    return Exported(out, said + left_out)


def bends(
    graph: AtlasGraph, picture: Picture, stations: Sequence[PlacedStation]
) -> dict[int, list[tuple[float, float]]]:
    """Return by edge the points between its ends that a way of straight lines along it needs."""
    ways: dict[int, list[tuple[float, float]]] = {}
    for station in stations:
        if station.is_between:
            ways.setdefault(station.edge, []).append(station.base[:2])
    found = {}
    for edge, way in ways.items():
        first, last = (picture.nodes[end.node][:2] for end in graph.edges[edge].ends)
        line = shapely.LineString([*without_detours([first, *way, last]), last])
        found[edge] = [(x, y) for x, y in list(line.simplify(_STRAIGHTER_M, preserve_topology=False).coords)[1:-1]]
    return found


def without_detours(way: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return a way (m) without what lies between two visits of one place: a robot goes to and fro about a node."""
    kept: list[tuple[float, float]] = []
    for place in way:
        again = next((n for n, other in enumerate(kept) if math.dist(place, other) < _AGAIN_M), None)
        if again is None:
            kept.append(place)
        else:
            del kept[again + 1 :]
    return kept


def tum_line(station: PlacedStation) -> str:
    """Return a pose as a line of a TUM trajectory: seconds, position, quaternion."""
    x, y, theta = station.base
    seconds = station.stamp_ns / NS_PER_S
    return f"{seconds:.6f} {x:.6f} {y:.6f} 0 0 0 {math.sin(theta / 2.0):.9f} {math.cos(theta / 2.0):.9f}\n"
