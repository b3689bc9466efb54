"""Figures 4 and 5 of the paper: all edge-maps tied to the floor, and one of them as it is stored."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from hslam_report.explored import PlacedEdgeMap
from hslam_report.page import ACCENT, LANDMARK, NODE, PATH, floor_page, legend_below, page
from hslam_sim.world import World
from hslam_types.se2 import SE2, Array

AXIS_SHARE = 0.06
"""Length of a drawn frame's axes, by the width of the floor."""
CHI_SQUARE_95 = 5.991
"""95 % of a two-dimensional Gaussian lies within this squared Mahalanobis distance."""
LARGEST_ELLIPSE_SHARE = 0.05
"""How much of the edge's length the largest landmark ellipse may take; sets the exaggeration."""
EXAGGERATIONS = (1, 2, 5, 10, 20, 50, 100, 200)


def tied_maps_figure(
    world: World, maps: Sequence[PlacedEdgeMap], nodes: Sequence[tuple[float, float]], framed: int
) -> Figure:
    """Return figure 4: every edge-map laid on the floor at its true meet points, the frame of map ``framed`` drawn.

    ``nodes`` are true places (m, in map).
    """
    figure, axes = floor_page(world)
    for placed in maps:
        terminal = placed.frame_in_map.apply(placed.terminal_x, 0.0)
        axes.plot(
            [placed.frame_in_map.x, terminal[0]], [placed.frame_in_map.y, terminal[1]], color=PATH, lw=0.7, alpha=0.5
        )
        points = placed.frame_in_map.apply_all(placed.landmarks)
        axes.plot(points[:, 0], points[:, 1], marker="*", color=LANDMARK, markersize=4.5, linestyle="none", mew=0.0)
    axes.plot([], [], marker="*", color=LANDMARK, linestyle="none", label="mapped landmarks")
    axes.plot([], [], color=PATH, lw=0.7, label="x axes of the edge-maps")
    if nodes:
        x, y = zip(*nodes, strict=True)
        axes.plot(x, y, marker="o", color=NODE, markersize=7, linestyle="none", label="nodes", zorder=4)
    if maps:
        _draw_frame(axes, maps[framed].frame_in_map, maps[framed].name)
    legend_below(figure, axes, 4)
    axes.set_title(f"{len(maps)} edge-maps tied to the true meet points of {world.name}", fontsize=11)
    return figure


def edge_map_figure(placed: PlacedEdgeMap) -> Figure:
    """Return figure 5: one edge-map in its own frame, with 95 % ellipses exaggerated by a stated factor."""
    low = np.minimum(placed.landmarks.min(axis=0, initial=0.0), 0.0) - 2.0
    high = np.maximum(placed.landmarks.max(axis=0, initial=0.0), (placed.terminal_x, 0.0)) + 2.0
    width, height = (high - low).tolist()
    figure, axes = page(11.0, min(max(11.0 * height / width, 2.5), 9.0) + 1.0)
    factor = exaggeration(placed)
    for index, point in enumerate(placed.landmarks):
        at = 2 + 2 * index
        _draw_ellipse(axes, point, placed.covariance[at : at + 2, at : at + 2], factor, LANDMARK)
    terminal = np.array([placed.terminal_x, 0.0])
    _draw_ellipse(axes, terminal, placed.covariance[:2, :2], factor, NODE)
    axes.plot(*placed.landmarks.T, marker="*", color=LANDMARK, markersize=6, linestyle="none", label="landmarks")
    axes.plot(*terminal, marker="x", color=NODE, markersize=9, mew=2.0, linestyle="none", label="terminal meet point")
    axes.plot(0.0, 0.0, marker="o", color=NODE, markersize=8, linestyle="none", label="first meet point (origin)")
    axes.axhline(0.0, color=PATH, linewidth=0.7, alpha=0.5, zorder=0)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x in the edge frame (m)")
    axes.set_ylabel("y (m)")
    shown = f"{len(placed.landmarks)} landmarks, 95 % ellipses x {factor}"
    axes.set_title(f"Edge-map {placed.name} in its own frame: {shown}", fontsize=11)
    legend_below(figure, axes, 3)
    return figure


def exaggeration(placed: PlacedEdgeMap) -> int:
    """Return the largest round factor at which the widest ellipse keeps within its share of the edge's length."""
    blocks = [placed.covariance[i : i + 2, i : i + 2] for i in range(0, len(placed.covariance), 2)]
    widest = max(math.sqrt(CHI_SQUARE_95 * max(float(np.linalg.eigvalsh(block)[-1]), 0.0)) for block in blocks)
    room = LARGEST_ELLIPSE_SHARE * max(placed.terminal_x, 1.0)
    return max((factor for factor in EXAGGERATIONS if factor * widest <= room), default=1)


def _draw_ellipse(axes: Axes, centre: Array, covariance: Array, factor: int, colour: str) -> None:
    """Draw the 95 % ellipse of a 2 x 2 covariance, its half axes ``factor`` times too long."""
    values, vectors = np.linalg.eigh(covariance)
    small, large = 2.0 * factor * np.sqrt(CHI_SQUARE_95 * np.maximum(values, 0.0))
    angle = math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    xy = (float(centre[0]), float(centre[1]))
    axes.add_patch(Ellipse(xy, large, small, angle=angle, fill=False, edgecolor=colour, linewidth=0.8, alpha=0.8))


def _draw_frame(axes: Axes, frame_in_map: SE2, name: str) -> None:
    """Draw the axes of an edge frame with its name."""
    origin = (frame_in_map.x, frame_in_map.y)
    length_m = AXIS_SHARE * axes.dataLim.width
    for tip, label in (((length_m, 0.0), "x"), ((0.0, length_m), "y")):
        end = frame_in_map.apply(*tip)
        axes.annotate("", xy=end, xytext=origin, arrowprops={"arrowstyle": "->", "color": ACCENT, "lw": 2.0}, zorder=6)
        text = frame_in_map.apply(1.12 * tip[0], 1.12 * tip[1])
        _make_room(axes, *text, margin_m=0.2 * length_m)
        axes.text(*text, label, color=ACCENT, ha="center", va="center", fontweight="bold", zorder=6)
    axes.plot([], [], color=ACCENT, lw=2.0, label=f"frame of edge-map {name}")


def _make_room(axes: Axes, x: float, y: float, margin_m: float) -> None:
    """Widen the limits so that a point lies well within."""
    left, right = axes.get_xlim()
    low, high = axes.get_ylim()
    axes.set_xlim(min(left, x - margin_m), max(right, x + margin_m))
    axes.set_ylim(min(low, y - margin_m), max(high, y + margin_m))
