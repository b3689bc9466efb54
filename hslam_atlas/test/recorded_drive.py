"""What a robot heard and said on a drive over the paper's floor, to be told to other atlases."""

from functools import cache

import numpy as np
from corridor_floor import furnish, wean_hall
from edge_walker import EdgeWalker, Step, WalkNoise

from hslam_atlas.config import AtlasConfig
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore

MAPPING = AtlasConfig(mission="none")


@cache
def recorded(goals: int = 10, seed: int = 0) -> tuple[Step, ...]:
    """Return the steps of an exploration up to so many goals."""
    walker = EdgeWalker(furnish(wean_hall(), np.random.default_rng(1000)), 0, np.random.default_rng(seed), WalkNoise())
    server = AtlasServer()
    steps: list[Step] = []
    goal = server.step((), (), ()).goal
    for _ in range(goals):
        assert goal is not None
        for step in walker.follow(goal):
            steps.append(step)
            goal = server.step(step.events, step.edge_maps, step.links).goal
    return tuple(steps)


def tell(server: AtlasServer, steps: tuple[Step, ...]) -> AtlasServer:
    """Let a server take these steps; return it."""
    for step in steps:
        server.step(step.events, step.edge_maps, step.links)
    return server


@cache
def learnt(goals: int = 10, seed: int = 0) -> tuple[str, ...]:
    """Return the content of the atlas the drive makes of an empty one."""
    with AtlasStore() as store:
        tell(AtlasServer(MAPPING, store), recorded(goals, seed))
        return tuple(store.dump())
