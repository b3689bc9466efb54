"""Two explorations of one floor, with other noise and from another start, become one atlas; of two floors, none."""

import dataclasses
import hashlib
from pathlib import Path

import pytest
from whole_runs import hslam, outcome

from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_bags.recorder import Recorder
from hslam_bringup.in_process_run import InProcessRun
from hslam_bringup.run_record import RunRecord
from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_gvg.level import level_from_mapping
from hslam_report.isomorphism import Embedding, embedding_of_truth, isomorphism
from hslam_sim.simulation import Simulation, SimulationConfiguration
from hslam_sim.truth import true_gvg
from hslam_sim.worlds import load_world
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

LIMIT_NS = 3_600 * 10**9


def explored(folder: Path, *, landmark_seed: int, seed: int, is_elsewhere: bool) -> Path:
    """Return the atlas of an exploration of `small_world`, begun at its start or in the midst of an edge."""
    world = load_world("small_world", landmark_seed=landmark_seed)
    if is_elsewhere:
        polyline = true_gvg(world).edges[-1].polyline
        x, y = polyline[len(polyline) // 2].tolist()
        world = dataclasses.replace(world, start=SE2(x, y, 1.0))
    folder.mkdir()
    with Recorder(folder / "bag") as recorder, AtlasStore(folder / "atlas.db") as store:
        run = InProcessRun(
            Simulation(world, SimulationConfiguration(), seed),
            level_from_mapping({}),
            EkfServer(EkfConfig()),
            AtlasServer(AtlasConfig(), store),
            RunRecord(recorder),
        )
        while not run.finished and run.simulation.stamp_ns < LIMIT_NS:
            run.step()
        run.atlas.save_rest()
    return folder / "atlas.db"


@pytest.fixture(scope="module")
def sessions(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return two atlases of one floor."""
    out = tmp_path_factory.mktemp("sessions")
    return (
        explored(out / "first", landmark_seed=1, seed=1, is_elsewhere=False),
        explored(out / "second", landmark_seed=1, seed=5, is_elsewhere=True),
    )


def graph_of(atlas: Path) -> AtlasGraph:
    """Return an atlas's graph."""
    with AtlasStore.reading(atlas) as store:
        return store.load()[0]


def embedding(graph: AtlasGraph) -> Embedding:
    """Return a graph as cyclic orders."""
    order = {node.id: node.slots() for node in graph.nodes.values()}
    across = {}
    for edge in graph.edges.values():
        ends = [(end.node, order[end.node].index(end.branch)) for end in edge.ends]
        across[ends[0]], across[ends[1]] = ends[1], ends[0]
    boundary = {node.id: node.kind is NodeKind.BOUNDARY_POINT for node in graph.nodes.values()}
    return Embedding(boundary, {node: len(slots) for node, slots in order.items()}, across)


@pytest.mark.parametrize("turned", [False, True])
def test_two_sessions_from_two_starts_are_one_floor(sessions: tuple[Path, Path], tmp_path: Path, turned: bool) -> None:
    first, second = sessions[::-1] if turned else sessions
    before = [hashlib.sha256(path.read_bytes()).hexdigest() for path in sessions]
    status, _, err = outcome(hslam("merge", str(first), str(second), "--out", str(tmp_path / "both.db")))
    assert status == 0, err
    assert [hashlib.sha256(path.read_bytes()).hexdigest() for path in sessions] == before
    assert [path.name for path in tmp_path.iterdir()] == ["both.db"]
    graph, own = graph_of(tmp_path / "both.db"), graph_of(first)
    truth = embedding_of_truth(true_gvg(load_world("small_world", landmark_seed=1)))
    assert isomorphism(embedding(graph), truth) is not None
    assert graph.edges.keys() == own.edges.keys()
    drives = [number for edge in graph.edges.values() for number in edge.traversals]
    assert len(drives) == len(set(drives))
    counted = sum(len(edge.traversals) for path in sessions for edge in graph_of(path).edges.values())
    assert len(drives) == counted, "what both have driven is used, each drive once"
    visits = [number for node in graph.nodes.values() for number, _ in node.visits]
    assert len(visits) == len(set(visits))
    # What became of it can be explored on, merged and drawn like any other.
    assert outcome(hslam("compare", str(tmp_path / "both.db"), str(tmp_path / "both.db")))[0] == 0


def test_a_floor_with_other_landmarks_is_refused_and_nothing_is_left(
    sessions: tuple[Path, Path], tmp_path: Path
) -> None:
    other = explored(tmp_path / "other", landmark_seed=2, seed=2, is_elsewhere=False)
    status, out, err = outcome(hslam("merge", str(sessions[0]), str(other), "--out", str(tmp_path / "both.db")))
    assert status == 1
    assert out == ""
    assert err.strip().splitlines()[-1].startswith("hslam: not joined: ")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other"]


def test_an_atlas_that_is_there_is_not_overwritten(sessions: tuple[Path, Path]) -> None:
    status, _, err = outcome(hslam("merge", *map(str, sessions), "--out", str(sessions[0])))
    assert status == 1
    assert "exists" in err
