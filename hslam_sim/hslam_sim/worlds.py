"""Find and load a world: a shipped name, a floor plan in YAML, or any map_server YAML with its image."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import shapely

from hslam_sim import floor_plan, raster_floor, raster_map, wall_landmarks
from hslam_sim.section import check_name
from hslam_sim.world import World, WorldError
from hslam_types.errors import ConfigurationError
from hslam_types.yaml_text import YamlError, load_yaml

PACKAGE = "hslam_sim"
LARGEST_FILE = 4_000_000
"""Bytes of YAML; a floor of a thousand corridors has a tenth of it."""


def load_world(name_or_path: str, *, landmark_seed: int = 0) -> World:
    """Return the world of a shipped name or of a YAML file; ``landmark_seed`` draws where the boxes stand.

    Raises WorldError (one line: the file, the key and what is wrong) when there is no such world or it cannot be used.
    """
    path = find_world(name_or_path)
    content = _read(path)
    try:
        return _build(path, content, landmark_seed)
    except (WorldError, ConfigurationError) as error:
        raise WorldError(f"{path}: {error}") from None
    except shapely.errors.ShapelyError as error:
        raise WorldError(f"{path}: its outline cannot be computed ({' '.join(str(error).split())})") from None
    except (MemoryError, cv2.error):
        raise WorldError(f"{path}: it needs more memory than there is") from None


def shipped_worlds() -> dict[str, Path]:
    """Return the shipped worlds by name, in alphabetical order."""
    beside_source = Path(__file__).resolve().parent.parent / "worlds"
    # An installed package keeps its data under share/, found as ament does but without importing ROS.
    prefixes = [Path(prefix) for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
    folders = [beside_source, *(prefix / "share" / PACKAGE / "worlds" for prefix in prefixes)]
    for folder in folders:
        found = sorted(folder.glob("*.yaml"))
        if found:
            return {path.stem: path for path in found}
    return {}


def find_world(name_or_path: str) -> Path:
    """Return the YAML file a name or path stands for; raises WorldError if there is none."""
    shipped = shipped_worlds()
    if name_or_path in shipped:
        return shipped[name_or_path]
    try:
        path = Path(name_or_path).expanduser()
        if path.is_file():
            return path
    except (OSError, RuntimeError) as error:  # a name that is too long, a home that nobody has
        raise WorldError(f"no world {name_or_path!r}: {error}") from None
    raise WorldError(f"no world '{name_or_path}': neither a YAML file nor one of {', '.join(shipped) or 'none'}")


def _read(path: Path) -> Mapping[str, Any]:
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise WorldError(f"{path}: is larger than the YAML of any world, {LARGEST_FILE} bytes")
        content = load_yaml(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"{path}: cannot be read ({error})") from None
    except YamlError as error:
        raise WorldError(f"{path}: is not YAML ({error})") from None
    if not isinstance(content, dict):
        raise WorldError(f"{path}: must be a mapping: a floor plan (corridors) or a map_server map (image)")
    return content


def _build(path: Path, content: Mapping[str, Any], landmark_seed: int) -> World:
    if "name" in content:
        check_name(content["name"], "name")
    if "image" in content:
        given = floor_plan.start_pose(content) if "start" in content else None
        floor = raster_floor.clean(raster_map.read(path.parent, content), given)
        free_space, start = floor.free_space, floor.start
    else:
        free_space, start = floor_plan.free_space(content), floor_plan.start_pose(content)
    density = floor_plan.landmark_density(content)
    landmarks = wall_landmarks.place(free_space, density, np.random.default_rng(landmark_seed))
    world = World(content.get("name", path.stem), free_space, start, landmarks)
    world.check_room(floor_plan.BODY_WIDTH_M / 2.0)
    return world
