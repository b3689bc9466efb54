"""A floor drawn by a person: corridors as centre lines with widths, doors and pilasters along their walls.

The format is described in `docs/floor_plans.md`.  What cannot be meant is refused by its place in the file.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import shapely

from hslam_sim.base_configuration import BaseConfiguration
from hslam_sim.corridor import Corridor, Feature
from hslam_sim.section import FARTHEST_M, Section, check_name, number, numbers, shown
from hslam_sim.wall_landmarks import WallLandmarks
from hslam_sim.world import WorldError
from hslam_types.se2 import SE2

KEYS_OF_ANY_WORLD = ("name", "about", "landmarks", "start")
"""A map_server map's YAML may hold them too."""
KEYS = (*KEYS_OF_ANY_WORLD, "features", "corridors", "rooms", "obstacles")
CORRIDOR_KEYS = ("name", "width", "line", "closed", "left", "right")
FEATURE_KEYS = ("shape", "width", "depth")
START_KEYS = ("x", "y", "heading_deg")
SIDES = {"left": 1.0, "right": -1.0}
LEAST_FEATURE_M = 0.01
BODY_WIDTH_M = 2.0 * BaseConfiguration().body_radius_m
"""Of a Scout, which passes no narrower corridor."""
GRID_M = 1e-6
"""Coordinates are rounded to a micrometre: unions of rectangles leave slivers below it."""


def free_space(content: Mapping[str, Any]) -> shapely.Polygon:
    """Return the free space a plan draws; raises WorldError on a key, type or geometry that is wrong."""
    plan = Section(content, "", KEYS)
    named = plan.section("features")
    features = {name: _feature(named.section(name, FEATURE_KEYS)) for name in named}
    added: list[shapely.Geometry] = []
    taken: list[shapely.Geometry] = []
    for place, entry in plan.items("corridors"):
        given = Section(entry, place, CORRIDOR_KEYS)
        corridor = _corridor(given)
        added.append(corridor.strip())
        for side, sign in SIDES.items():
            for where, kind, at_m in _along(given.section(side)):
                if kind not in features:
                    raise WorldError(f"{where}: there is no feature {shown(kind)}")
                (added if features[kind].recess else taken).append(corridor.beside(features[kind], sign, at_m))
    added.extend(_polygon(place, room) for place, room in plan.items("rooms"))
    taken.extend(_polygon(place, obstacle) for place, obstacle in plan.items("obstacles"))
    drawn = shapely.union_all(added).difference(shapely.union_all(taken))
    drawn = shapely.set_precision(drawn, GRID_M).simplify(GRID_M)
    if not isinstance(drawn, shapely.Polygon) or drawn.is_empty:
        parts = 0 if drawn.is_empty else shapely.get_num_geometries(drawn)
        less = ", less the obstacles," if taken else ""
        raise WorldError(f"corridors and rooms{less} do not form one connected floor, but {parts} parts")
    return drawn


def start_pose(content: Mapping[str, Any]) -> SE2:
    """Return the start pose a plan or a map's YAML names under ``start``; raises WorldError if it is malformed."""
    try:
        start = Section(content.get("start"), "start", START_KEYS)
        x, y = start.number("x"), start.number("y")
        heading_deg = start.number("heading_deg", -360.0, 360.0)
    except WorldError as error:
        raise WorldError(f"'start' must be a mapping {{x: m, y: m, heading_deg: degrees}}: {error}") from None
    return SE2(x, y, math.radians(heading_deg))


def landmark_density(content: Mapping[str, Any]) -> WallLandmarks:
    """Return the ``landmarks`` section, or the default; raises WorldError or ConfigurationError on a bad value."""
    known = [entry.name for entry in WallLandmarks.parameters()]
    landmarks = Section(content.get("landmarks", {}), "landmarks", known)
    return WallLandmarks.from_mapping({name: landmarks.value(name) for name in landmarks})


def _feature(given: Section) -> Feature:
    shape = given.text("shape")
    if shape not in ("recess", "pilaster"):
        raise WorldError(f"{given.at('shape')} must be recess or pilaster, not {shown(shape)}")
    width_m, depth_m = (given.number(key, LEAST_FEATURE_M) for key in ("width", "depth"))
    return Feature(shape == "recess", width_m, depth_m)


def _corridor(given: Section) -> Corridor:
    if "name" in given:
        check_name(given.value("name"), given.at("name"))
        given.place = f"corridor '{given.value('name')}'"
    width_m = given.number("width", 0.0)
    if width_m < BODY_WIDTH_M:
        raise WorldError(f"{given.at('width')}: {width_m:g} m is narrower than the body, {BODY_WIDTH_M:g} m")
    closed = given.flag("closed")
    line = np.array([numbers(point, place, "[x, y] in metres") for place, point in given.items("line")])
    if len(line) < (3 if closed else 2):
        raise WorldError(f"{given.at('line')} must have at least {'three' if closed else 'two'} points [x, y]")
    if closed:
        line = np.vstack([line, line[:1]])
    still = np.flatnonzero(np.hypot(*np.diff(line, axis=0).T) < GRID_M)
    if len(still):
        raise WorldError(f"{given.at('line')} has the point {line[still[0]].tolist()} twice in a row")
    return Corridor(given.place, width_m, line, closed)


def _along(side: Section) -> Iterator[tuple[str, str, float]]:
    """Yield every feature along one side: how errors name it, its name, and its middle's metre along the line."""
    for kind in side:
        for place, at_m in side.items(kind):
            yield place, kind, number(at_m, place, 0.0, FARTHEST_M)


def _polygon(place: str, corners: Any) -> shapely.Polygon:
    """Return a room or an obstacle."""
    if not isinstance(corners, list | tuple) or len(corners) < 3:
        raise WorldError(f"{place} must be a list of at least three corners [x, y], not {shown(corners)}")
    points = [numbers(corner, f"{place}[{index}]", "[x, y] in metres") for index, corner in enumerate(corners)]
    shape = shapely.Polygon(points)
    if not shape.is_valid:
        raise WorldError(f"{place} is no polygon: {shapely.is_valid_reason(shape)}")
    return shape
