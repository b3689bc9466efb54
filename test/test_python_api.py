"""The page about the Python API: its code runs as it stands, and what it calls says the truth."""

import itertools
import math
import re
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

from hslam_atlas import open_atlas
from hslam_atlas.atlas_reading import NoSuchPlaceError
from hslam_atlas.errors import StoreError
from hslam_atlas.routes import PER_NODE_M
from hslam_bags.bag import Bag
from hslam_bringup.bag_loop import rebuild_atlas
from hslam_bringup.run_options import RunOptions
from hslam_types.se2 import SE2, wrap

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "python_api.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the atlas the page speaks of, made of the sample bag."""
    folder = tmp_path_factory.mktemp("api")
    out = folder / "runs" / "small_world_1"
    out.mkdir(parents=True)
    with Bag(ROOT / "bags" / "samples" / "small_world_1") as bag:
        rebuild_atlas(bag, RunOptions("", 0, out))
    return folder


def test_the_page_runs_as_it_stands(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 5
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)  # noqa: S102 - the page's own code
    said = capsys.readouterr().out
    assert "4 nodes 4 edges 1 part" in said
    assert "pose [4.  0.2 0.5]" in said


def test_plans_are_shortest_ways(folder: Path) -> None:
    with open_atlas(folder / "runs/small_world_1/atlas.db") as atlas:
        network: nx.MultiGraph[int] = nx.MultiGraph()
        for edge in atlas.edges.values():
            network.add_edge(edge.ends[0].node, edge.ends[1].node, key=edge.id, cost=edge.path_length_m + PER_NODE_M)
        for start, goal in itertools.permutations(atlas.nodes, 2):
            plan = atlas.plan(start, goal)
            assert (plan.nodes[0], plan.nodes[-1]) == (start, goal)
            for here, edge_id, there in zip(plan.nodes[:-1], plan.edges, plan.nodes[1:], strict=True):
                assert {end.node for end in atlas.edges[edge_id].ends} == {here, there}
            assert plan.length_m == pytest.approx(sum(atlas.edges[edge].path_length_m for edge in plan.edges))
            best = nx.dijkstra_path_length(network, start, goal, weight="cost")
            assert plan.length_m + PER_NODE_M * len(plan.edges) == pytest.approx(best)
        assert atlas.plan(0, 0).edges == ()
        with pytest.raises(NoSuchPlaceError, match="no node 99"):
            atlas.plan(0, 99)
        with pytest.raises(NoSuchPlaceError, match="no edge 99"):
            atlas.edge_map(99)


def test_a_look_from_anywhere_is_found_there_or_left_open(folder: Path) -> None:
    """Looks from all edges, with noise, clutter and what is missed; never a place that is none."""
    rng = np.random.default_rng(3)
    right = 0
    with open_atlas(folder / "runs/small_world_1/atlas.db") as atlas:
        frames = atlas.picture().edge_frames
        looks = 30
        for _ in range(looks):
            edge_id = int(rng.choice(list(atlas.edges)))
            edge_map = atlas.edge_map(edge_id)
            stands_by = edge_map.landmarks[int(rng.integers(edge_map.size))]
            x, y = (stands_by + rng.uniform(-1.0, 1.0, 2)).tolist()
            pose = SE2(x, y, float(rng.uniform(-3.0, 3.0)))
            seen = pose.inverse().apply_all(edge_map.landmarks)
            seen = seen[(np.hypot(*seen.T) < 4.5) & (rng.random(len(seen)) < 0.9)]
            look = np.concatenate((seen + rng.normal(0.0, 0.02, seen.shape), rng.uniform(-4.0, 4.0, (1, 2))))
            place = atlas.localise(look)
            if place is not None:
                at, true = frames[place.edge] @ place.base_in_edge, frames[edge_id] @ pose
                assert math.dist(at[:2], true[:2]) < 0.5
                assert abs(wrap(at.theta - true.theta)) < 0.2
                right += 1
    assert right >= 0.6 * looks


def test_a_look_at_nothing_known_has_no_place(folder: Path) -> None:
    rng = np.random.default_rng(5)
    with open_atlas(folder / "runs/small_world_1/atlas.db") as atlas:
        for count in (0, 3, 12):
            assert atlas.localise(rng.uniform(-4.0, 4.0, (count, 2))) is None


def test_what_is_no_atlas_is_told(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="no such file"), open_atlas(tmp_path / "none.db"):
        pass
