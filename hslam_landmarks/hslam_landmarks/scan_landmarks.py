"""From a planar scan to a look: every landmark in it as range and bearing in base_link."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from hslam_landmarks.config import ScanLandmarksConfig, ScannerConfig
from hslam_landmarks.corners import Point, corners
from hslam_landmarks.faces import faces
from hslam_landmarks.outline import outline
from hslam_landmarks.poles import poles
from hslam_types.se2 import SE2, rotation
from hslam_types.sensing import FieldOfView, LandmarkSighting, LandmarkView, RangeScan

_NEAREST_M = 0.1
"""A landmark nearer than this to base_link's origin has no bearing to speak of."""
_CLOSED = 1.5
"""A gap in the round of less than so many steps between beams is the usual one before the first beam."""


class ScanLandmarks:
    """Looks at every so manieth scan."""

    def __init__(self, config: ScanLandmarksConfig | None = None) -> None:
        """Begin to count scans."""
        self._config = config or ScanLandmarksConfig()
        self._scans = 0

    def hear(self, scan: RangeScan) -> LandmarkView | None:
        """Return the look of a scan, which may hold no landmark; None for a scan that is passed over."""
        self._scans += 1
        return look(scan, self._config) if self._scans % self._config.look_every == 0 else None


def lookout_from_mapping(values: Mapping[str, Any]) -> tuple[ScanLandmarks, ScannerConfig]:
    """Return what looks at scans, and where they are taken, by parameters as a node has them.

    Raises ConfigurationError on a bad one.
    """
    own = {entry.name for entry in ScannerConfig.parameters()}
    scanner = ScannerConfig.from_mapping({name: value for name, value in values.items() if name in own})
    config = ScanLandmarksConfig.from_mapping({name: value for name, value in values.items() if name not in own})
    return ScanLandmarks(config), scanner


def look(scan: RangeScan, config: ScanLandmarksConfig) -> LandmarkView:
    """Return the landmarks of one scan, by bearing."""
    range_max_m = min(config.range_max_m, scan.range_max_m)
    field = _field(scan)
    seen = outline(scan, config.range_std_m)
    if seen is None:
        return LandmarkView(scan.stamp_ns, range_max_m, (), field)
    free = poles(seen, config)
    points = [*free.values(), *corners(seen, faces(seen, config, free), config)]
    sightings = (_sighting(point, scan.sensor_in_base, config) for point in _apart(points, config))
    told = [s for s in sightings if s is not None and _NEAREST_M < s.range_m < range_max_m]
    return LandmarkView(scan.stamp_ns, range_max_m, tuple(sorted(told, key=lambda seen: seen.bearing)), field)


def _field(scan: RangeScan) -> FieldOfView:
    """Return what a scan could have shown; beams that come round to the first again leave no gap."""
    x, y, theta = scan.sensor_in_base
    span = scan.bearing_step * max(len(scan.ranges) - 1, 0)
    if span + _CLOSED * scan.bearing_step >= math.tau:
        return FieldOfView(x, y, range_min_m=scan.range_min_m)
    first = theta + scan.first_bearing
    return FieldOfView(x, y, first, first + span, scan.range_min_m)


def _apart(points: list[Point], config: ScanLandmarksConfig) -> list[Point]:
    """Return the points well known, best first, none within the least gap of a better one."""
    kept: list[Point] = []
    for point in sorted(points, key=lambda p: float(np.trace(p.covariance))):
        worst = 0.5 * np.trace(point.covariance) + math.hypot(
            0.5 * float(point.covariance[0, 0] - point.covariance[1, 1]), float(point.covariance[0, 1])
        )
        if worst <= config.worst_std_m**2 and all(
            math.dist(point.place, other.place) >= config.least_gap_m for other in kept
        ):
            kept.append(point)
    return kept


def _sighting(point: Point, sensor_in_base: SE2, config: ScanLandmarksConfig) -> LandmarkSighting | None:
    """Return a point as range and bearing in base_link with the deviation of each."""
    x, y = sensor_in_base.apply(*point.place.tolist())
    range_m = math.hypot(x, y)
    if range_m <= _NEAREST_M:
        return None
    turned = rotation(sensor_in_base.theta)
    covariance = turned @ point.covariance @ turned.T + config.still_std_m**2 * np.eye(2)
    radial, across = np.array([x, y]) / range_m, np.array([-y, x]) / range_m**2
    return LandmarkSighting(
        range_m,
        math.atan2(y, x),
        math.sqrt(float(radial @ covariance @ radial)),
        math.sqrt(float(across @ covariance @ across)),
    )
