"""The picture of the whole floor, chained and by least squares, against the true landmarks."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hslam_report.explored import PlacedEdgeMap
from hslam_report.landmark_score import associate, rigid_fit
from hslam_report.page import ACCENT, CAPTION_IN, LANDMARK, PATH, WIDTH_IN
from hslam_sim.truth.draw import draw_floor
from hslam_sim.world import World
from hslam_types.se2 import Array

_LONGER = 5.0
"""How much longer errors are drawn than they are."""


def picture_figure(world: World, maps: Sequence[PlacedEdgeMap]) -> Figure | None:
    """Return the two pictures side by side, or one below the other; None where no landmark has a true one."""
    pairs = [associate(placed.frame_in_map.apply_all(placed.landmarks), world.landmarks) for placed in maps]
    if not sum(len(rows) for rows, _ in pairs):
        return None
    truth = np.concatenate([world.landmarks[columns] for _, columns in pairs])
    chained = np.concatenate([placed.chained[rows] for placed, (rows, _) in zip(maps, pairs, strict=True)])
    optimised = np.concatenate([placed.optimised[rows] for placed, (rows, _) in zip(maps, pairs, strict=True)])
    min_x, min_y, max_x, max_y = world.free_space.bounds
    is_wide = max_x - min_x > max_y - min_y
    share = (max_y - min_y) / (max_x - min_x)
    figure = Figure(figsize=(WIDTH_IN, (2.0 if is_wide else 0.5) * WIDTH_IN * share + CAPTION_IN), layout="constrained")
    FigureCanvasAgg(figure)
    both = figure.subplots(2, 1) if is_wide else figure.subplots(1, 2)
    _draw(both[0], world, chained, truth, "along shortest chains of edges")
    _draw(both[1], world, optimised, truth, "by least squares over all edge-maps")
    return figure


def _draw(axes: Axes, world: World, picture: Array, truth: Array, name: str) -> None:
    draw_floor(axes, world)
    off = rigid_fit(picture, truth).apply_all(picture) - truth
    lines = np.stack((truth, truth + _LONGER * off, np.full_like(truth, np.nan)), axis=1).reshape(-1, 2)
    axes.plot(*truth.T, marker="o", color=LANDMARK, markersize=2.0, linestyle="none", mew=0.0)
    axes.plot(*lines.T, color=PATH if name.startswith("by") else ACCENT, linewidth=1.0)
    rmse = float(np.sqrt((off**2).sum(axis=1).mean()))
    axes.set_title(f"Landmarks {name}: {rmse:.3f} m rms, errors drawn {_LONGER:g} times as long", fontsize=11)
