"""What a person asks of a robot that has an atlas: which atlas, which world, which robot."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import StoreError
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_bringup.node_parameters import ALGORITHMS, check_settings
from hslam_bringup.run_options import merged, robot_settings
from hslam_bringup.simulated_robot import simulation_configuration
from hslam_sim.world import World
from hslam_sim.worlds import load_world


@dataclass(frozen=True, eq=False)
class Errand:
    """An atlas, the world it is of, and a robot in it."""

    atlas: Path
    world: World
    settings: Mapping[str, Mapping[str, Any]]
    """Parameters by node and name, over the defaults."""

    @property
    def body_radius_m(self) -> float:
        """The radius of the robot's body."""
        return simulation_configuration(self.settings.get("sim", {})).base.body_radius_m


def errand(atlas: Path, world: str, world_seed: int, robot: str, settings: Mapping[str, Mapping[str, Any]]) -> Errand:
    """Return an errand; raises HslamError (one line) where world, robot or settings are none."""
    chosen = merged(robot_settings(robot), settings)
    check_settings(chosen, ALGORITHMS)
    return Errand(atlas, load_world(world, landmark_seed=world_seed), chosen)


@contextmanager
def atlas_state(path: Path, config: AtlasConfig | None = None) -> Iterator[AtlasState]:
    """Open an atlas to read alone; raises StoreError where it cannot be read or is empty."""
    config = config or AtlasConfig()
    with AtlasStore.reading(path) as store:
        graph, _ = store.load()
        if not graph.edges:
            raise StoreError(f"{path}: an atlas without edges; explore a floor first")
        counts = store.counts()
        alike = LookAlikes.from_counts(config.repetition, counts)
        yield AtlasState(config, graph, store, alike)
