"""What the driving wants of a local map, whatever sensor draws it; places in odom (m)."""

from typing import Any, Protocol

from hslam_gvg.local_graph.gaps import Gaps
from hslam_gvg.local_graph.open_space import OpenSpace
from hslam_gvg.ranging.rolling_grid import Mask
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import OdometrySample, Velocity


class LocalMap(Protocol):
    """Obstacle points, known free space and unknown space round the robot."""

    def hear(self, heard: Any, odom: OdometrySample, odometer_m: float, *, attentive: bool) -> SE2:
        """Take what the sensor said in one cycle; an attentive robot minds all of it, though it stands.

        Return where the robot is by the map itself: its own pose, or near it.
        """

    def touch(self, x: float, y: float, odometer_m: float) -> None:
        """Note an obstacle that the body met and the sensor does not show."""

    def obstacle_points(self) -> Array:
        """Return what is taken for obstacles, n x 2."""

    def is_free(self, x: Array, y: Array) -> Mask:
        """Return which points lie where it is known to be free."""

    def open_space(self) -> OpenSpace:
        """Return where it is known free, and far from every obstacle known."""

    def gaps(self, begin: Array, end: Array) -> Gaps:
        """Return of each gap between two obstacle points (each n x 2) whether it is open, shut, or nobody knows."""

    def recent(self) -> Array:
        """Return where the latest answers came from (n x 2), before the map believes them: to keep off."""

    def limited(self, wanted: Velocity, base_in_odom: SE2, obstacles: Array) -> tuple[Velocity, bool]:
        """Return the command that the sensor's own doubts allow, and whether it had to be stopped.

        ``obstacles`` (n x 2) are those of the last look.
        """
