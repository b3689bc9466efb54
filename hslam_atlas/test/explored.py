"""An exploration at the level of events, and how it ended."""

from dataclasses import dataclass

import numpy as np
from corridor_floor import CorridorFloor
from edge_walker import EdgeWalker, WalkNoise

from hslam_atlas.config import AtlasConfig
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore


@dataclass
class Explored:
    """How an exploration ended."""

    walker: EdgeWalker
    server: AtlasServer
    finished: bool

    def true_nodes(self) -> dict[int, set[int]]:
        """Return, for each node of the atlas, the true nodes it was visited at."""
        return {
            node.id: {self.walker.true_node[sequence] for sequence, _ in node.visits}
            for node in self.server.state.graph.nodes.values()
        }

    def false_closures(self) -> int:
        """Return how many nodes of the atlas are several true ones."""
        return sum(len(places) > 1 for places in self.true_nodes().values())

    def is_isomorphic(self) -> bool:
        """Whether the atlas, with its visits' true nodes as names, is exactly the floor's graph."""
        names = {node: min(places) for node, places in self.true_nodes().items()}
        ends = (
            tuple(sorted((names[e.ends[0].node], names[e.ends[1].node])))
            for e in self.server.state.graph.edges.values()
        )
        truth = sorted(tuple(sorted((c.start, c.stop))) for c in self.walker.floor.corridors)
        return sorted(names.values()) == sorted(self.walker.floor.nodes) and sorted(ends) == truth


def explore(
    floor: CorridorFloor,
    start: int,
    seed: int,
    noise: WalkNoise,
    *,
    goals: int = 120,
    store: AtlasStore | None = None,
    config: AtlasConfig | None = None,
) -> Explored:
    """Let a walker do what the atlas asks until it has finished or ``goals`` are used up."""
    walker = EdgeWalker(floor, start, np.random.default_rng(seed), noise)
    server = AtlasServer(config or AtlasConfig(), store=store)
    goal = server.step((), (), ()).goal
    finished = False
    for _ in range(goals):
        assert goal is not None
        steps = walker.follow(goal)
        outputs = [server.step(s.events, s.edge_maps, s.links) for s in steps]
        goal, finished = outputs[-1].goal, outputs[-1].finished
        if finished:
            break
    return Explored(walker, server, finished)
