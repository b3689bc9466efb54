"""A corridor as a floor plan draws it: a strip along a centre line, with recesses and pilasters along its walls."""

from dataclasses import dataclass

import numpy as np
import shapely

from hslam_sim.world import WorldError
from hslam_types.se2 import Array


@dataclass(frozen=True)
class Feature:
    """What may stand along a wall."""

    recess: bool
    """Whether it goes into the wall; a pilaster stands out of it."""
    width_m: float
    """Along the wall."""
    depth_m: float


@dataclass(frozen=True, eq=False)
class Corridor:
    """One corridor, in map (m)."""

    place: str
    """How errors name it."""
    width_m: float
    line: Array
    """Centre line, n x 2; a closed one comes back to its first point."""
    closed: bool

    def strip(self) -> shapely.Geometry:
        """Return the strip around the centre line, with square corners and square ends."""
        shape = shapely.LinearRing(self.line[:-1]) if self.closed else shapely.LineString(self.line)
        return shape.buffer(self.width_m / 2.0, cap_style="flat", join_style="mitre")

    def beside(self, feature: Feature, sign: float, at_m: float) -> shapely.Polygon:
        """Return the rectangle of a recess behind the wall, or of a pilaster before it, ``at_m`` along the line.

        ``sign`` is 1 on the left, -1 on the right; raises WorldError where the line has ended.
        """
        steps = np.diff(self.line, axis=0)
        ends = np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))
        if not 0.0 <= at_m <= ends[-1]:
            raise WorldError(f"{self.place} is {ends[-1]:g} m long; no feature fits at {at_m:g} m")
        which = int(np.searchsorted(ends, at_m))
        along = steps[which] / np.hypot(*steps[which])
        outward = sign * np.array([-along[1], along[0]])
        middle = self.line[which + 1] - along * (ends[which] - at_m)
        wall, half, depth = self.width_m / 2.0, feature.width_m / 2.0, feature.depth_m
        # A recess overlaps the corridor and a pilaster the wall, so that no sliver stays between them.
        near, far = (wall / 2.0, wall + depth) if feature.recess else (wall - depth, wall + 0.1)
        corners = [(-half, near), (half, near), (half, far), (-half, far)]
        return shapely.Polygon([middle + a * along + b * outward for a, b in corners])
