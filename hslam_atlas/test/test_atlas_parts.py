"""An atlas in parts: what was begun anew is joined to what it is a part of, and nodes without a map are forgotten."""

from pathlib import Path

import numpy as np
import pytest
from corridor_floor import furnish, wean_hall
from edge_walker import EdgeWalker, WalkNoise

from hslam_atlas.config import AtlasConfig
from hslam_atlas.picture import parts
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView

FLOOR = furnish(wean_hall(), np.random.default_rng(1003))
VIEW = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.2, (0.0, 2.0, -2.0))


def walked(server: AtlasServer, start: int, seed: int, goals: int) -> EdgeWalker:
    """Let a walker, put down at a node, do what the atlas asks until it has finished or goals are used up."""
    walker = EdgeWalker(FLOOR, start, np.random.default_rng(seed), WalkNoise())
    goal = server.step((), (), ()).goal
    for _ in range(goals):
        assert goal is not None
        for step in walker.follow(goal):
            output = server.step(step.events, step.edge_maps, step.links)
        goal = output.goal
        if output.finished:
            break
    return walker


@pytest.mark.parametrize("start", [3, 7])
def test_who_wakes_up_where_the_atlas_knows_nothing_joins_what_it_finds_to_it(tmp_path: Path, start: int) -> None:
    """The first session ends after six drives; the second begins elsewhere, and never says it is found meanwhile."""
    with AtlasStore(tmp_path / "atlas.db") as store:
        first = AtlasServer(AtlasConfig(mission="explore"), store)
        walked(first, 0, 3, 6)
        first.save()
    with AtlasStore(tmp_path / "atlas.db") as store:
        second = AtlasServer(AtlasConfig(mission="explore", localise_drives=1), store)
        walked(second, start, 4, 150)
        graph = second.state.graph
        assert len(parts(graph)) == 1
        assert (len(graph.nodes), len(graph.edges), second.unexplored) == (13, 16, 0)


def test_a_node_without_a_map_is_found_anew(tmp_path: Path) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        first = AtlasServer(AtlasConfig(mission="explore"), store)
        first.step((), (), ())
        first.step((GvgEvent(0, 1, EventKind.ACCESS), GvgEvent(1, 2, EventKind.ARRIVAL, VIEW, -1)), (), ())
        first.save()
        assert list(first.state.graph.nodes) == [0]
    with AtlasStore(tmp_path / "atlas.db") as store:
        second = AtlasServer(AtlasConfig(mission="explore", localise_drives=1), store)
        assert list(second.state.graph.nodes) == [0]
        second.step((), (), ())
        second.step((GvgEvent(0, 1, EventKind.ACCESS), GvgEvent(1, 2, EventKind.ARRIVAL, VIEW, -1)), (), ())
        assert 0 not in second.state.graph.nodes
