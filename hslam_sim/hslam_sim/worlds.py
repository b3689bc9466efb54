"""Find and load a world: a shipped name, a floor plan in YAML, or any map_server YAML with its image."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hslam_sim import floor_plan, raster_floor, raster_map, wall_landmarks
from hslam_sim.world import World, WorldError
from hslam_types.errors import ConfigurationError
from hslam_types.yaml_text import YamlError, load_yaml

PACKAGE = "hslam_sim"


def load_world(name_or_path: str, *, landmark_seed: int = 0) -> World:
    """Return the world of a shipped name or of a YAML file; ``landmark_seed`` draws where the boxes stand.

    Raises WorldError (one line: the file and what is wrong) when there is no such world or it cannot be used.
    """
    path = find_world(name_or_path)
    content = _read(path)
    try:
        world = _build(path, content, landmark_seed)
    except (WorldError, ConfigurationError) as error:
        raise WorldError(f"{path}: {error}") from None
    except KeyError as error:
        raise WorldError(f"{path}: the key {error} is missing") from None
    except (TypeError, ValueError, AttributeError) as error:
        raise WorldError(f"{path}: a value is wrong ({error})") from None
    return world


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
    path = Path(name_or_path).expanduser()
    if not path.is_file():
        raise WorldError(f"no world '{name_or_path}': neither a YAML file nor one of {', '.join(shipped) or 'none'}")
    return path


def _read(path: Path) -> Mapping[str, Any]:
    try:
        content = load_yaml(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"{path}: cannot be read ({error})") from None
    except YamlError as error:
        raise WorldError(f"{path}: is not YAML ({error})") from None
    if not isinstance(content, dict):
        raise WorldError(f"{path}: must be a mapping: a floor plan (corridors) or a map_server map (image)")
    return content


def _build(path: Path, content: Mapping[str, Any], landmark_seed: int) -> World:
    if "image" in content:
        given = floor_plan.start_pose(content) if "start" in content else None
        floor = raster_floor.clean(raster_map.read(path.parent, content), given)
        free_space, start = floor.free_space, floor.start
    else:
        free_space, start = floor_plan.free_space(content), floor_plan.start_pose(content)
    density = floor_plan.landmark_density(content)
    landmarks = wall_landmarks.place(free_space, density, np.random.default_rng(landmark_seed))
    return World(str(content.get("name", path.stem)), free_space, start, landmarks)
