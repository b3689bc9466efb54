"""A floor as the simulator and the truth see it: free space, landmarks and where the robot starts."""

import functools
from dataclasses import dataclass

import numpy as np
import shapely

from hslam_sim.errors import SimulatorError
from hslam_types.se2 import SE2, Array


class WorldError(SimulatorError):
    """A world cannot be found, read or used; the text names the file and what to change."""


@dataclass(frozen=True, eq=False)
class World:
    """One connected floor in the map frame (m, rad).

    Raises WorldError if the free space is not one valid polygon or the start lies outside it.
    """

    name: str
    free_space: shapely.Polygon
    """Where a point may be; holes are islands.  Counter-clockwise outside, clockwise holes."""
    start: SE2
    """Pose of base_link in map at the beginning of a run."""
    landmarks: Array
    """Unlabelled boxes on the walls, n x 2."""

    def __post_init__(self) -> None:
        """Orient the rings and check the start."""
        if not isinstance(self.free_space, shapely.Polygon) or self.free_space.is_empty:
            raise WorldError(f"world '{self.name}' has no single connected free space")
        if not self.free_space.is_valid:
            raise WorldError(f"world '{self.name}': {shapely.is_valid_reason(self.free_space)}")
        if not shapely.contains_xy(self.free_space, self.start.x, self.start.y):
            raise WorldError(
                f"world '{self.name}': the start ({self.start.x:g}, {self.start.y:g}) is not in free space"
            )
        object.__setattr__(self, "free_space", shapely.geometry.polygon.orient(self.free_space, 1.0))

    @functools.cached_property
    def walls(self) -> Array:
        """Every wall segment as (x1, y1, x2, y2), m x 4, with free space on its left."""
        rings = [np.asarray(ring.coords) for ring in (self.free_space.exterior, *self.free_space.interiors)]
        return np.concatenate([np.hstack([ring[:-1], ring[1:]]) for ring in rings])

    @property
    def corners(self) -> Array:
        """Where walls meet or end, n x 2 (m): what a lidar may take for landmarks."""
        return self.walls[:, :2]

    def check_room(self, body_radius_m: float) -> None:
        """Raise WorldError unless the round body fits where it starts."""
        room_m = self.clearance(self.start.x, self.start.y)
        if room_m < body_radius_m:
            raise WorldError(f"start: {room_m:.2f} m to the nearest wall; the body needs {body_radius_m:g} m")

    def clearance(self, x: float, y: float) -> float:
        """Return the distance (m) from a point in map to the nearest wall."""
        return float(self.free_space.boundary.distance(shapely.Point(x, y)))
