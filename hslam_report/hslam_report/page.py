"""A figure on paper: its size, its colours, and saving it as PNG and SVG that are the same for the same run."""

from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hslam_sim.truth.draw import draw_floor
from hslam_sim.world import World

PATH = "#1f6fb4"
NODE = "#22223b"
LANDMARK = "#d1495b"
ACCENT = "#e07a1f"
FAINT = "#9aa5b1"
WIDTH_IN = 11.0
CAPTION_IN = 1.3
LABELS_IN = 0.5
"""What the ticks and the x axis's label take under the axes."""
LEAST_DRAWING_IN, MOST_DRAWING_IN = 2.5, 12.0
SUFFIXES = (".png", ".svg")


def page(width_in: float, height_in: float) -> tuple[Figure, Axes]:
    """Return an empty figure drawn without a display, and its axes."""
    figure = Figure(figsize=(width_in, height_in))
    FigureCanvasAgg(figure)
    return figure, figure.add_subplot()


def floor_page(world: World) -> tuple[Figure, Axes]:
    """Return a figure with the floor of ``world`` drawn on it, in map (m)."""
    min_x, min_y, max_x, max_y = world.free_space.bounds
    figure, axes = page(WIDTH_IN, WIDTH_IN)
    draw_floor(axes, world)
    fit_height(figure, (max_y - min_y) / (max_x - min_x))
    return figure, axes


def fit_height(figure: Figure, height_by_width: float) -> None:
    """Give the page the height that a drawing of these proportions needs, within reason."""
    height = min(max(WIDTH_IN * height_by_width, LEAST_DRAWING_IN), MOST_DRAWING_IN)
    figure.set_size_inches(WIDTH_IN, height + CAPTION_IN)


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write ``name``.png and ``name``.svg to a folder, which is made if it is missing, and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}{suffix}" for suffix in SUFFIXES]
    # Without a fixed salt and with a date, two runs of one seed would differ in their SVG.
    with mpl.rc_context({"svg.hashsalt": "hslam", "savefig.bbox": "tight"}):
        figure.savefig(paths[0], dpi=150, metadata={"Software": None})
        figure.savefig(paths[1], metadata={"Date": None})
    return paths


def legend_below(figure: Figure, axes: Axes, columns: int) -> None:
    """Put the legend under the axes, out of the drawing's way."""
    below = -LABELS_IN / (axes.get_position().height * figure.get_figheight())
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, below), ncols=columns, frameon=False)
