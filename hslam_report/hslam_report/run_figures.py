"""The figures of one run, in one folder."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hslam_report.explored import ExploredGraph, PlacedEdgeMap
from hslam_report.map_figures import edge_map_figure, tied_maps_figure
from hslam_report.page import save
from hslam_report.path_figures import DrivenPath, loop_figure, path_figure
from hslam_report.picture_figure import picture_figure
from hslam_report.visits import places, position
from hslam_sim.world import World
from hslam_types.se2 import Array

LEAST_AREA_M2 = 10.0
"""Less than that is the scatter of driving a corridor up and down."""


@dataclass(frozen=True, slots=True)
class Loop:
    """A drive from a node back to it."""

    node: int
    """Its id."""
    first: int
    """Step at which it was left."""
    last: int
    """Step at which it was reached again."""


def write_figures(
    folder: Path,
    world: World,
    driven: DrivenPath,
    graph: ExploredGraph,
    maps: Sequence[PlacedEdgeMap],
    step_of_event: Mapping[int, int],
) -> list[Path]:
    """Write figures 3 to 6 of the paper, and 7, both pictures of the whole, as PNG and SVG and return their paths.

    A figure with nothing to show is left out.  ``step_of_event`` gives the row of ``driven`` at which the event of each
    visit's sequence number was announced.
    """
    at = {node.id: position(node) for node in graph.nodes}
    nodes = list(at.values())
    paths = save(path_figure(world, driven, nodes), folder, "figure_3_path_by_odometry")
    if maps:
        shown = richest(maps)
        paths += save(tied_maps_figure(world, maps, nodes, shown), folder, "figure_4_edge_maps")
        paths += save(edge_map_figure(maps[shown]), folder, "figure_5_edge_map")
    loop = widest_loop(graph, driven, step_of_event)
    if loop is not None:
        figure = loop_figure(world, driven, loop.first, loop.last, at[loop.node], str(loop.node))
        paths += save(figure, folder, "figure_6_loop_closing")
    pictures = picture_figure(world, maps)
    if pictures is not None:
        paths += save(pictures, folder, "figure_7_picture")
    return paths


def richest(maps: Sequence[PlacedEdgeMap]) -> int:
    """Return the index of the edge-map with the most landmarks, the first of equals."""
    return max(range(len(maps)), key=lambda index: (len(maps[index].landmarks), -index))


def widest_loop(graph: ExploredGraph, driven: DrivenPath, step_of_event: Mapping[int, int]) -> Loop | None:
    """Return the drive between two visits of one node, none between them, that encloses the largest area.

    A drive out and back by the same way encloses none; visits at a false place are not the node's.
    """
    best: tuple[float, Loop] | None = None
    for node in graph.nodes:
        steps = [step_of_event[visit.sequence] for visit in places(node)[0]]
        for first, last in itertools.pairwise(steps):
            area = enclosed_area_m2(driven.in_map[first : last + 1])
            if area >= LEAST_AREA_M2 and (best is None or area > best[0]):
                best = area, Loop(node.id, first, last)
    return None if best is None else best[1]


def enclosed_area_m2(poses: Array) -> float:
    """Return the area that a closed path of poses (n x 3) goes round (the shoelace formula)."""
    x, y = poses[:, 0], poses[:, 1]
    return abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) / 2.0
