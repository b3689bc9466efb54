"""Figures 3 and 6 of the paper: the path as odometry saw it, over the floor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hslam_report.page import ACCENT, FAINT, LANDMARK, NODE, PATH, fit_height, floor_page, legend_below
from hslam_sim.world import World
from hslam_types.se2 import SE2, Array


@dataclass(frozen=True, slots=True, eq=False)
class DrivenPath:
    """A run's poses of base_link, one row a step."""

    in_odom: Array
    """x, y, theta by odometry, n x 3."""
    in_map: Array
    """The truth, n x 3."""


def path_figure(world: World, driven: DrivenPath, nodes: Sequence[tuple[float, float]]) -> Figure:
    """Return figure 3: the odometric path laid on the floor by its first pose, with the visited nodes (m, in map)."""
    figure, axes = floor_page(world)
    axes.plot(driven.in_map[:, 0], driven.in_map[:, 1], color=FAINT, linewidth=0.8, label="true path", zorder=2)
    laid = laid_on_map(driven, 0)
    axes.plot(laid[:, 0], laid[:, 1], color=PATH, linewidth=1.1, label="path by odometry", zorder=3)
    _mark_nodes(axes, nodes)
    axes.plot(*driven.in_map[0, :2], marker="^", color=ACCENT, markersize=10, linestyle="none", label="start", zorder=5)
    _widen(figure, axes, laid)
    legend_below(figure, axes, 4)
    axes.set_title(f"Path by odometry over {world.name}: {length_m(driven.in_odom):.1f} m", fontsize=11)
    return figure


def loop_figure(
    world: World, driven: DrivenPath, first: int, last: int, node: tuple[float, float], name: str
) -> Figure:
    """Return figure 6: the odometric path round a loop, from step ``first`` to step ``last`` at one node (m, in map).

    The path is laid on the floor at its first pose, so that the gap at its end is what odometry lost on the way.
    """
    part = DrivenPath(driven.in_odom[first : last + 1], driven.in_map[first : last + 1])
    laid = laid_on_map(part, 0)
    figure, axes = floor_page(world)
    axes.plot(laid[:, 0], laid[:, 1], color=PATH, linewidth=1.1, label="path by odometry", zorder=3)
    axes.plot(*node, marker="o", color=NODE, markersize=8, linestyle="none", label=f"node {name}, truly", zorder=4)
    ends = laid[[0, -1], :2]
    axes.plot(ends[:, 0], ends[:, 1], color=LANDMARK, linestyle=":", linewidth=1.2, zorder=4)
    for end, text, marker in ((ends[0], "left", "^"), (ends[1], "reached again", "s")):
        label = f"node {name} by odometry, when {text}"
        axes.plot(*end, marker=marker, color=LANDMARK, markersize=9, linestyle="none", label=label, zorder=5)
    _widen(figure, axes, laid)
    legend_below(figure, axes, 2)
    gap = float(np.hypot(*(ends[1] - ends[0])))
    axes.set_title(
        f"The loop through node {name}: {length_m(part.in_odom):.1f} m, odometry {gap:.1f} m off", fontsize=11
    )
    return figure


def laid_on_map(driven: DrivenPath, step: int) -> Array:
    """Return the odometric path (n x 2) in map, true at one step."""
    odom_in_map = SE2(*driven.in_map[step]) @ SE2(*driven.in_odom[step]).inverse()
    return odom_in_map.apply_all(driven.in_odom[:, :2])


def length_m(poses: Array) -> float:
    """Return the length of a path of poses (n x 3); a stop at its end, however long it was recorded, adds nothing."""
    steps = np.diff(poses[:, :2], axis=0)
    return math.fsum(np.hypot(steps[:, 0], steps[:, 1]))


def _mark_nodes(axes: Axes, nodes: Sequence[tuple[float, float]]) -> None:
    if nodes:
        x, y = zip(*nodes, strict=True)
        axes.plot(x, y, marker="o", color=NODE, markersize=6, linestyle="none", label="nodes", zorder=4)


def _widen(figure: Figure, axes: Axes, laid: Array) -> None:
    """Let the axes hold a path that leaves the floor."""
    low, high = laid.min(axis=0) - 1.0, laid.max(axis=0) + 1.0
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    left, right, bottom, top = min(left, low[0]), max(right, high[0]), min(bottom, low[1]), max(top, high[1])
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    fit_height(figure, (top - bottom) / (right - left))
