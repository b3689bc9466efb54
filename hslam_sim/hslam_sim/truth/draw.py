"""Draw a world and its true reduced GVG."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from hslam_sim.truth.gvg import TrueGvg, TrueKind, TrueNode
from hslam_sim.world import World

FLOOR, WALL, EDGE = "#ffffff", "#5b6470", "#1f6fb4"
COLOURS = {TrueKind.MEET_POINT: "#d1495b", TrueKind.BOUNDARY_POINT: "#edae49"}
LABELS = {TrueKind.MEET_POINT: "meet point", TrueKind.BOUNDARY_POINT: "boundary point"}


def draw_true_gvg(world: World, gvg: TrueGvg, path: Path) -> None:
    """Write a picture of the floor, its edges and its nodes to ``path`` (.png or .svg by its ending)."""
    figure = Figure(figsize=(12.0, 12.0 * _aspect(world) + 1.2), layout="tight")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    draw_floor(axes, world)
    for edge in gvg.edges:
        axes.plot(edge.polyline[:, 0], edge.polyline[:, 1], color=EDGE, linewidth=1.4, zorder=2)
    for kind, colour in COLOURS.items():
        _mark(axes, (n for n in gvg.nodes if n.kind is kind and n.core), colour, LABELS[kind], filled=True)
        _mark(axes, (n for n in gvg.nodes if n.kind is kind and not n.core), colour, f"{LABELS[kind]}, optional")
    boundary = sum(node.is_boundary for node in gvg.nodes)
    core = sum(node.core for node in gvg.nodes)
    axes.set_title(
        f"{world.name}: true reduced GVG, {len(gvg.nodes)} nodes ({boundary} boundary, "
        f"{len(gvg.nodes) - boundary} meet; {core} core), {len(gvg.edges)} edges, {gvg.cycles} cycles",
        fontsize=11,
    )
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=6, frameon=False)
    figure.savefig(path, dpi=150, bbox_inches="tight")


def draw_floor(axes: Axes, world: World) -> None:
    """Draw the free space of a world, its walls and equal axes in metres."""
    rings = [np.asarray(ring.coords) for ring in (world.free_space.exterior, *world.free_space.interiors)]
    outline = Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))
    axes.add_patch(PathPatch(outline, facecolor=FLOOR, edgecolor=WALL, linewidth=0.8, zorder=0))
    axes.set_facecolor("#e9ecef")
    min_x, min_y, max_x, max_y = world.free_space.bounds
    margin = 0.02 * max(max_x - min_x, max_y - min_y)
    axes.set_xlim(min_x - margin, max_x + margin)
    axes.set_ylim(min_y - margin, max_y + margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x in map (m)")
    axes.set_ylabel("y in map (m)")


def _aspect(world: World) -> float:
    min_x, min_y, max_x, max_y = world.free_space.bounds
    return float((max_y - min_y) / (max_x - min_x))


def _mark(axes: Axes, nodes: Iterable[TrueNode], colour: str, label: str, *, filled: bool = False) -> None:
    points = np.array([(node.x, node.y) for node in nodes])
    if len(points):
        face = colour if filled else "#ffffff"
        axes.scatter(points[:, 0], points[:, 1], s=42, color=face, edgecolors=colour, label=label, zorder=3)
