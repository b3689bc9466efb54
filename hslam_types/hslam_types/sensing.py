"""What the robot's sensors say, one value per message.

Stamps are integer nanoseconds of ROS time; angles are counter-clockwise from base_link's x axis (REP-103).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hslam_types.se2 import SE2, Array, wrap_all


class Velocity(NamedTuple):
    """A differential drive's twist in base_link: forward m/s and counter-clockwise rad/s."""

    forward: float = 0.0
    turn: float = 0.0


class PlanarCovariance(NamedTuple):
    """A covariance over x, y (m or m/s) and theta (rad or rad/s): its upper triangle row by row, as a source gave it.

    Nothing is promised of the numbers: they may be NaN, negative or contradict each other.
    """

    xx: float
    xy: float
    xt: float
    yy: float
    yt: float
    tt: float

    @property
    def matrix(self) -> Array:
        """The covariance as 3 x 3."""
        xx, xy, xt, yy, yt, tt = self
        return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])


@dataclass(frozen=True, slots=True)
class OdometrySample:
    """Dead reckoning at one stamp: the pose of base_link in odom and the measured velocity."""

    stamp_ns: int
    base_in_odom: SE2
    velocity: Velocity = Velocity()  # noqa: RUF009 (a NamedTuple, immutable)
    twist_covariance: PlanarCovariance | None = None
    """Of the velocity forward, to the left and of the turn, in base_link; None where none was given."""
    pose_covariance: PlanarCovariance | None = None
    """Of ``base_in_odom``, by odom's axes; None where none was given."""


class SonarPing(NamedTuple):
    """One firing of one sonar; ``range_m`` from the transducer's face, +inf where nothing answered (REP-117)."""

    sensor: int
    stamp_ns: int
    range_m: float


@dataclass(frozen=True, slots=True)
class SonarRing:
    """The fixed geometry of a ring of sonars: where each looks from and how it hears."""

    bearings: tuple[float, ...]
    """Direction of each sonar's axis in base_link (rad)."""
    mount_radius_m: float
    """Distance of every transducer's face from base_link's origin."""
    range_min_m: float
    range_max_m: float
    cone_half_angle: float
    """Half the main lobe (rad)."""


@dataclass(frozen=True, slots=True)
class SonarSweep:
    """The pings since the last sweep, oldest first; may be empty."""

    stamp_ns: int
    ring: SonarRing
    pings: tuple[SonarPing, ...]


@dataclass(frozen=True, slots=True, eq=False)
class RangeScan:
    """The ranges of a planar scanner, taken at one stamp."""

    stamp_ns: int
    sensor_in_base: SE2
    """Pose of the scanner in base_link."""
    first_bearing: float
    """Direction (rad) of the first beam in the scanner's frame; each next one lies ``bearing_step`` on."""
    bearing_step: float
    range_min_m: float
    range_max_m: float
    ranges: Array
    """Metres, one a beam: +inf where nothing answered, -inf too near, NaN for no reading (REP-117)."""

    @property
    def bearings(self) -> Array:
        """The directions of the beams in the scanner's frame (rad)."""
        directions: Array = self.first_bearing + self.bearing_step * np.arange(len(self.ranges), dtype=np.float64)
        return directions


class LandmarkSighting(NamedTuple):
    """An unlabelled point landmark in base_link: range (m), bearing (rad), each with its standard deviation."""

    range_m: float
    bearing: float
    range_std_m: float
    bearing_std: float


class FieldOfView(NamedTuple):
    """Where a landmark sensor sees: a sector about its place, counter-clockwise from one direction to another."""

    sensor_x: float = 0.0
    """The sensor's place in base_link (m)."""
    sensor_y: float = 0.0
    bearing_from: float = 0.0
    """Directions by base_link's axes (rad); two that are equal: all round."""
    bearing_to: float = 0.0
    range_min_m: float = 0.0
    """Nearer to the sensor than this it sees nothing."""

    def shows(self, places: Array, range_max_m: float, margins: Array) -> npt.NDArray[np.bool_]:
        """Tell which places (k x 2, range and bearing from base_link) lie inside up to a range from the sensor.

        ``margins`` (k, rad): by how much each must be inside the sector's edges.
        """
        distance, bearing = places[:, 0], places[:, 1]
        if self.sensor_x or self.sensor_y:
            x = distance * np.cos(bearing) - self.sensor_x
            y = distance * np.sin(bearing) - self.sensor_y
            distance, bearing = np.hypot(x, y), np.arctan2(y, x)
        inside = (distance < range_max_m) & (distance >= self.range_min_m)
        half = 0.5 * ((self.bearing_to - self.bearing_from) % math.tau)
        if half:
            inside &= np.abs(wrap_all(bearing - self.bearing_from - half)) + margins < half
        return inside


@dataclass(frozen=True, slots=True)
class LandmarkView:
    """One look of a landmark sensor: all that is in its field within ``range_max_m`` of it should have been seen."""

    stamp_ns: int
    range_max_m: float
    sightings: tuple[LandmarkSighting, ...]
    field: FieldOfView = FieldOfView()  # noqa: RUF009 (a NamedTuple, immutable)


SCOUT_RING = SonarRing(
    bearings=tuple(math.remainder(i * math.pi / 8.0, 2.0 * math.pi) for i in range(16)),
    mount_radius_m=0.19,
    range_min_m=0.1524,
    range_max_m=6.477,
    cone_half_angle=math.radians(15.0),
)
"""The Nomadic Scout's ring: index 0 forward, counter-clockwise; 6 to 255 whole inches."""
