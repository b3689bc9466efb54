"""A floor drawn by a person: corridors as centre lines with widths, doors and pilasters along their walls.

```yaml
features:                                    # what may stand along a wall, by name
  door: {shape: recess, width: 0.96, depth: 0.2}
  pilaster: {shape: pilaster, width: 0.3, depth: 0.25}
corridors:
  - {name: main, width: 2.4, line: [[0, 0], [20, 0]], closed: false,
     left: {door: [3.2, 8.0]}, right: {pilaster: [5.1]}}   # metres along the line to the feature's middle
rooms: [[[20, -3], [26, -3], [26, 3], [20, 3]]]            # optional polygons added to the free space
obstacles: []                                              # optional polygons taken from it
landmarks: {per_metre: 1.0}                                # see `WallLandmarks`
start: {x: 1.0, y: 0.0, heading_deg: 0.0}
```
Sides are as seen walking along the line; everything is in metres, in the map frame.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely

from hslam_sim.wall_landmarks import WallLandmarks
from hslam_sim.world import WorldError
from hslam_types.se2 import SE2, Array

KEYS = frozenset({"name", "about", "features", "corridors", "rooms", "obstacles", "landmarks", "start"})
CORRIDOR_KEYS = frozenset({"name", "width", "line", "closed", "left", "right"})
SIDES = {"left": 1.0, "right": -1.0}
GRID_M = 1e-6
"""Coordinates are rounded to a micrometre: unions of rectangles leave slivers below it."""


def free_space(plan: Mapping[str, Any]) -> shapely.Polygon:
    """Return the free space a plan draws; raises WorldError on a key, type or geometry that is wrong."""
    _only(plan, KEYS, "the plan")
    features: Mapping[str, Any] = plan.get("features") or {}
    added: list[shapely.Geometry] = []
    taken: list[shapely.Geometry] = []
    for corridor in plan.get("corridors") or []:
        _only(corridor, CORRIDOR_KEYS, f"corridor '{corridor.get('name', '?')}'")
        added.append(_corridor(corridor))
        for side, sign in SIDES.items():
            for kind, places in (corridor.get(side) or {}).items():
                if kind not in features:
                    raise WorldError(f"corridor '{corridor['name']}' uses the unknown feature '{kind}'")
                feature = features[kind]
                into = {"recess": added, "pilaster": taken}.get(feature["shape"])
                if into is None:
                    raise WorldError(f"feature '{kind}': shape must be recess or pilaster, not '{feature['shape']}'")
                into.extend(_feature(corridor, feature, sign, float(at)) for at in places)
    added.extend(shapely.Polygon(room) for room in plan.get("rooms") or [])
    taken.extend(shapely.Polygon(obstacle) for obstacle in plan.get("obstacles") or [])
    drawn = shapely.union_all(added).difference(shapely.union_all(taken))
    drawn = shapely.set_precision(drawn, GRID_M).simplify(GRID_M)
    if not isinstance(drawn, shapely.Polygon):
        raise WorldError("the plan's corridors and rooms do not form one connected floor")
    return drawn


def start_pose(plan: Mapping[str, Any]) -> SE2:
    """Return the start pose a plan or a map's YAML names under ``start``; raises WorldError if it is malformed."""
    start: Any = plan.get("start")
    try:
        x, y, heading = (float(start[key]) for key in ("x", "y", "heading_deg"))
    except (TypeError, KeyError, ValueError):
        raise WorldError("'start' must be a mapping {x: metres, y: metres, heading_deg: degrees}") from None
    return SE2(x, y, math.radians(heading))


def landmark_density(plan: Mapping[str, Any]) -> WallLandmarks:
    """Return the plan's ``landmarks`` section, or the default; raises ConfigurationError on a bad value."""
    return WallLandmarks.from_mapping(plan.get("landmarks") or {})


def _only(given: Mapping[str, Any], known: frozenset[str], where: str) -> None:
    unknown = sorted(set(given) - known)
    if unknown:
        raise WorldError(f"{where} has the unknown key '{unknown[0]}'; known are: {', '.join(sorted(known))}")


def _corridor(corridor: Mapping[str, Any]) -> shapely.Geometry:
    """Return the strip around a centre line, with square corners and square ends."""
    line = _line(corridor)
    shape = shapely.LinearRing(line[:-1]) if corridor.get("closed") else shapely.LineString(line)
    return shape.buffer(float(corridor["width"]) / 2.0, cap_style="flat", join_style="mitre")


def _line(corridor: Mapping[str, Any]) -> Array:
    """Return a corridor's centre line (n x 2, m), its first point repeated at the end if it is closed."""
    line: Sequence[Sequence[float]] = corridor["line"]
    closed = [line[0]] if corridor.get("closed") else []
    points = np.array([*line, *closed], dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise WorldError(f"corridor '{corridor['name']}': line must be a list of at least two [x, y]")
    return points


def _feature(corridor: Mapping[str, Any], feature: Mapping[str, Any], sign: float, at: float) -> shapely.Polygon:
    """Return the rectangle of a recess behind the wall, or of a pilaster before it, ``at`` metres along the line."""
    line = _line(corridor)
    steps = np.diff(line, axis=0)
    ends = np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))
    if not 0.0 <= at <= ends[-1]:
        raise WorldError(f"corridor '{corridor['name']}' is {ends[-1]:g} m long; no feature fits at {at:g} m")
    which = int(np.searchsorted(ends, at))
    along = steps[which] / np.hypot(*steps[which])
    outward = sign * np.array([-along[1], along[0]])
    middle = line[which + 1] - along * (ends[which] - at)
    wall, half, depth = float(corridor["width"]) / 2.0, float(feature["width"]) / 2.0, float(feature["depth"])
    # A recess overlaps the corridor and a pilaster the wall, so that no sliver stays between them.
    near, far = (wall / 2.0, wall + depth) if feature["shape"] == "recess" else (wall - depth, wall + 0.1)
    corners = [(-half, near), (half, near), (half, far), (-half, far)]
    return shapely.Polygon([middle + a * along + b * outward for a, b in corners])
