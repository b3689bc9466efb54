"""Open space: what is known free and far from every obstacle in sight; the graph takes its outline for a wall.

So a hall wider than the sensor reaches has a graph too, along its walls: the extended Voronoi graph (Beeson, Jong and
Kuipers, 2005), by the same distance as the truth's (`hslam_voronoi.rules`).
"""

from dataclasses import dataclass

import numpy as np

from hslam_gvg.local_graph.cuts import IsFree
from hslam_types.se2 import Array


@dataclass(frozen=True, eq=False)
class OpenSpace:
    """Where there is open space, in odom (m)."""

    outline: Array
    """Points along its outline, n x 2, near enough to each other that no way leads between them."""
    holds: IsFree
    """Tells of points, by x and y (each n), which lie in it."""


NONE = OpenSpace(np.zeros((0, 2)), lambda x, _: np.zeros(len(x), bool))
"""No open space: what a ring of sonars makes of any place, for it hears walls one by one."""
