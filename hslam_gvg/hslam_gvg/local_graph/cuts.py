"""Where the local graph is cut: a ridge that leaves what is known ends there, in an exit.

Each function gives links of vertices (k x 3: place and clearance, m) exits of their own, as further vertices, and tells
how far (m) a branch may go on beyond each.
"""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_types.se2 import Array

Mask = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]
IsFree = Callable[[Array, Array], Mask]

FREE_STEP_M = 0.1
"""Free space is followed in such steps."""


def in_gaps(
    vertices: Array, links: Indices, known: Mask, middle: Array, doubted: Mask
) -> tuple[Array, Indices, dict[int, float]]:
    """Let each link through a gap nobody knows end in the gap's ``middle`` (m x 3), from either side that is known."""
    extra: list[Array] = []
    more: list[tuple[int, int]] = []
    for column in (1, 0):
        for row in np.flatnonzero(doubted & known[links[:, 1 - column]]):
            more.append((int(links[row, 1 - column]), len(vertices) + len(extra)))
            extra.append(middle[row])
    ends = {len(vertices) + k: 0.0 for k in range(len(extra))}
    links = np.concatenate((links[~doubted], np.array(more, dtype=np.int64).reshape(-1, 2)))
    return np.vstack([vertices, *extra]), links, ends


def at_end_of_free(
    vertices: Array,
    links: Indices,
    known: Mask,
    sites: Array,
    is_free: IsFree,
    config: LocalGraphConfig,
    horizon: float,
) -> tuple[Array, Indices, dict[int, float]]:
    """Give each link that leaves the known an exit of its own, at the end of its free part; ``sites``: one of each."""
    extra: list[Array] = []
    beyond: dict[int, float] = {}
    steps = np.arange(1, round(config.into_free_m / FREE_STEP_M) + 1) * FREE_STEP_M
    for column in (1, 0):
        rows = np.flatnonzero(~known[links[:, column]])
        inside = vertices[links[rows, 1 - column]]
        way = vertices[links[rows, column], :2] - inside[:, :2]
        length = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)
        unit = way / length[:, None]
        px = inside[:, 0, None] + unit[:, 0, None] * steps
        py = inside[:, 1, None] + unit[:, 1, None] * steps
        free = is_free(px.ravel(), py.ravel()).reshape(px.shape) & (steps < length[:, None])
        count = np.where(free.all(axis=1), len(steps), free.argmin(axis=1))
        at = np.minimum(np.maximum(count * FREE_STEP_M, FREE_STEP_M), length)
        place = inside[:, :2] + unit * at[:, None]
        clearance = np.hypot(*(place - sites[rows]).T)
        far = np.hypot(place[:, 0], place[:, 1]) > horizon
        first = len(vertices) + len(extra)
        for k in range(len(rows)):
            beyond[first + k] = math.inf if far[k] else config.exit_credit * float(clearance[k])
            extra.append(np.array([place[k, 0], place[k, 1], clearance[k]]))
        links[rows, column] = first + np.arange(len(rows))
    return np.vstack([vertices, *extra]), links, beyond
