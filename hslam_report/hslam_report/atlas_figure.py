"""An atlas drawn by itself, without any truth: nodes with their numbers, edges, landmarks with their ellipses."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from hslam_report.page import ACCENT, FAINT, LANDMARK, NODE, PATH, fit_height, legend_below, page
from hslam_types.se2 import SE2, Array, rotation

FORMATS: dict[str, dict[str, None]] = {
    ".pdf": {"CreationDate": None},
    ".png": {"Software": None},
    ".svg": {"Date": None},
}
"""By ending: what would make two files of one figure differ, or two versions of the library."""
_CHI_SQUARE_95 = 5.991
_EXAGGERATION = 5.0
"""Ellipses of landmarks are drawn so much longer: true to scale they would not be seen on a floor."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnNode:
    """A node in the picture (m)."""

    number: int
    place: tuple[float, float]
    covariance: Array
    """2 x 2, against the node that gives the frame."""
    is_boundary: bool
    unexplored: int
    """Branches nobody has driven along."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnEdge:
    """An edge in the picture (m)."""

    number: int
    ends: tuple[int, int]
    """Numbers of its nodes."""
    frame: SE2
    landmarks: Array
    """n x 2."""
    covariance: Array
    """(2 + 2n) x (2 + 2n), in the edge's frame, the terminal first."""


def atlas_figure(nodes: Sequence[DrawnNode], edges: Sequence[DrawnEdge], title: str) -> Figure:
    """Return the drawing; shapes tell apart what colours do, so that it can be read in grey."""
    figure, axes = page(7.0, 7.0)
    places = {node.number: node.place for node in nodes}
    for edge in edges:
        line = np.array([places[end] for end in edge.ends])
        axes.plot(*line.T, color=PATH, linewidth=1.2, zorder=2)
        x, y = line.mean(axis=0).tolist()
        axes.annotate(str(edge.number), (x, y), color=PATH, fontsize=6, ha="center", va="center", zorder=5,
                      bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none"})  # fmt: skip
        axes.plot(*edge.landmarks.T, marker=".", color=LANDMARK, markersize=1.5, linestyle="none", mew=0.0, zorder=3)
        turn = rotation(edge.frame.theta)
        blocks = [edge.covariance[i : i + 2, i : i + 2] for i in range(2, len(edge.covariance), 2)]
        _ellipses(axes, edge.landmarks, [turn @ block @ turn.T for block in blocks], _EXAGGERATION, LANDMARK, 0.3)
    _ellipses(axes, np.array([n.place for n in nodes]), [n.covariance for n in nodes], _EXAGGERATION, ACCENT, 0.9)
    _mark(axes, [n for n in nodes if not n.is_boundary], "o", "meet points")
    _mark(axes, [n for n in nodes if n.is_boundary], "s", "boundary points")
    for node in nodes:
        axes.annotate(str(node.number), node.place, color="white", fontsize=5.5, ha="center", va="center", zorder=7)
    open_ended = [node for node in nodes if node.unexplored]
    if open_ended:
        axes.plot(*zip(*(n.place for n in open_ended), strict=True), marker="*", color=ACCENT, markersize=15,
                  linestyle="none", zorder=5, label="unexplored branches")  # fmt: skip
    axes.plot([], [], color=PATH, linewidth=1.2, label="edges")
    axes.plot([], [], marker=".", color=LANDMARK, linestyle="none", label=f"landmarks, 95 % x {_EXAGGERATION:g}")
    axes.plot([], [], marker="o", mfc="none", color=ACCENT, linestyle="none", label=f"nodes, 95 % x {_EXAGGERATION:g}")
    axes.set_aspect("equal")
    axes.grid(color=FAINT, linewidth=0.3, alpha=0.5)
    axes.set_xlabel("x in the first node's frame (m)", fontsize=8)
    axes.set_ylabel("y (m)", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.set_title(title, fontsize=9)
    left, right, low, high = (*axes.get_xlim(), *axes.get_ylim())
    fit_height(figure, (high - low) / max(right - left, 1e-6))
    legend_below(figure, axes, 3)
    return figure


def save_drawing(figure: Figure, path: Path) -> None:
    """Write a figure in the format of its name's ending, one of `FORMATS`: the same bytes for the same figure."""
    with mpl.rc_context({"svg.hashsalt": "hslam", "savefig.bbox": "tight", "pdf.fonttype": 42}):
        figure.savefig(path, dpi=200, metadata=FORMATS[path.suffix])


def _mark(axes: Axes, nodes: Sequence[DrawnNode], marker: str, label: str) -> None:
    if nodes:
        x, y = zip(*(node.place for node in nodes), strict=True)
        axes.plot(x, y, marker=marker, color=NODE, markersize=9, linestyle="none", zorder=6, label=label)


def _ellipses(
    axes: Axes, centres: Array, covariances: Sequence[Array], factor: float, colour: str, width: float
) -> None:
    """Draw 95 % ellipses of 2 x 2 covariances, their axes ``factor`` times as long."""
    if not covariances:
        return
    values, vectors = np.linalg.eigh(np.array(covariances))
    axis = 2.0 * factor * np.sqrt(_CHI_SQUARE_95 * np.maximum(values, 0.0))
    angles = np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))
    axes.add_collection(
        EllipseCollection(
            axis[:, 1], axis[:, 0], angles, units="xy", offsets=centres, offset_transform=axes.transData,
            facecolors="none", edgecolors=colour, linewidths=width, zorder=4,
        )
    )  # fmt: skip
