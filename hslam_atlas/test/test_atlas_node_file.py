"""The node and its file: held by others, full, replaced by another; what it shows of it to whoever comes late."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from broken_rows import Attack, atlas, broken
from hslam_msgs.msg import Atlas, NodeStatus
from hslam_msgs.srv import AtlasFile
from ros_stage import Staged
from test_atlas_node import Pair, walker
from visualization_msgs.msg import Marker, MarkerArray

from hslam_atlas.atlas_in_use import AtlasInUse
from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import StoreError
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_ros.qos import LATCHED


def stored(path: Path, goals: int = 4) -> Path:
    """Write an atlas to a file."""
    with AtlasStore(path) as store:
        server, base = AtlasServer(store=store), walker()
        goal = server.step((), (), ()).goal
        for _ in range(goals):
            assert goal is not None
            for step in base.follow(goal):
                goal = server.step(step.events, step.edge_maps, step.links).goal
    return path


def nodes_in(path: Path) -> int:
    with AtlasStore.reading(path) as store:
        return len(store.load()[0].nodes)


def test_a_held_file_stops_no_robot_and_is_written_when_it_is_free(staged: Staged, tmp_path: Path) -> None:
    """Held before the first arrival, when the file is not in write-ahead mode yet; freed while nothing happens."""
    path = tmp_path / "atlas.db"
    pair = staged(Pair, store=path)
    pair.rest.open_actions()
    with closing(sqlite3.connect(path, isolation_level=None)) as reader:
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM nodes").fetchone()
        pair.explore(3)
        told: NodeStatus = pair.rest.statuses[-1]
        assert told.state == "exploring"
        assert "not saved: " in told.detail
        assert "is locked" in told.detail
        refused = pair.call(pair.rest, AtlasFile, "atlas/load", AtlasFile.Request(path=str(stored(tmp_path / "b.db"))))
        assert not refused.success
        assert "is locked" in refused.message
    known = len(pair.atlas._server.state.graph.nodes)
    assert known > 1
    pair.spin_until(lambda: nodes_in(path) == known)
    pair.cycle(10**12, None)
    assert "not saved" not in pair.rest.statuses[-1].detail


def test_what_cannot_be_saved_at_the_end_is_told(staged: Staged, tmp_path: Path) -> None:
    path = tmp_path / "atlas.db"
    pair = staged(Pair, store=path)
    pair.rest.open_actions()
    with closing(sqlite3.connect(path, isolation_level=None)) as writer:
        writer.execute("BEGIN EXCLUSIVE")
        pair.explore(2)
        with pytest.raises(StoreError, match=r"atlas\.db: cannot be written .*locked"):
            pair.atlas.close()
    pair.atlas._server.unsaved = None  # told once; the stage closes the node again


def test_what_could_not_be_saved_before_is_saved_at_the_end(staged: Staged, tmp_path: Path) -> None:
    path = tmp_path / "atlas.db"
    pair = staged(Pair, store=path)
    pair.rest.open_actions()
    with closing(sqlite3.connect(path, isolation_level=None)) as writer:
        writer.execute("BEGIN EXCLUSIVE")
        pair.explore(2)
    known = len(pair.atlas._server.state.graph.nodes)
    pair.atlas.close()
    assert nodes_in(path) == known
    assert [file.name for file in tmp_path.iterdir()] == ["atlas.db"]


ROWS = (
    Attack("edges", "traversals", "no JSON"),
    Attack("edge_maps", "map", b"\xff" * 96),
    Attack("visits", "node", 99),
    Attack("meta", "value", "[]", "counts"),
)


def test_broken_files_are_refused_and_the_node_lives_on(staged: Staged, tmp_path: Path) -> None:
    pair = staged(Pair, store=tmp_path / "atlas.db")
    pair.rest.open_actions()
    pair.explore(2)
    known = len(pair.atlas._server.state.graph.nodes)
    for attack in ROWS:
        path = broken(atlas(tmp_path / "broken.db"), attack)
        before = path.read_bytes()
        told = pair.call(pair.rest, AtlasFile, "atlas/load", AtlasFile.Request(path=str(path)))
        assert not told.success
        assert f"broken.db: cannot be read (table {attack.table}, row" in told.message
        assert path.read_bytes() == before
        pair.cycle(10**12 + len(pair.rest.statuses), None)
        assert pair.rest.statuses[-1].detail.startswith(f"{known} nodes, ")


@pytest.mark.parametrize("attack", ROWS, ids=str)
def test_a_node_does_not_begin_with_a_broken_file(tmp_path: Path, attack: Attack) -> None:
    path = broken(atlas(tmp_path / "broken.db"), attack)
    with pytest.raises(StoreError, match=rf"broken\.db: cannot be read \(table {attack.table}, row"):
        AtlasInUse(AtlasConfig(), path)


@pytest.mark.parametrize("how", ["parameter", "service"])
def test_an_atlas_taken_up_is_shown_before_the_robot_moves(staged: Staged, tmp_path: Path, how: str) -> None:
    path = stored(tmp_path / "atlas.db")
    pair = staged(Pair, mission="none", **({"store": path} if how == "parameter" else {}))
    if how == "service":
        assert pair.call(pair.rest, AtlasFile, "atlas/load", AtlasFile.Request(path=str(path))).success
    pair.spin_until(lambda: bool(pair.rest.graphs))
    assert len(pair.rest.graphs[-1].nodes) == nodes_in(path)


def test_who_comes_late_sees_the_atlas_and_its_markers(staged: Staged) -> None:
    pair = staged(Pair)
    pair.rest.open_actions()
    pair.explore(3)
    drawn: list[MarkerArray] = []
    graphs: list[Atlas] = []
    pair.rest.create_subscription(MarkerArray, "atlas/markers", drawn.append, LATCHED)
    pair.rest.create_subscription(Atlas, "atlas/atlas", graphs.append, LATCHED)
    pair.spin_until(lambda: bool(drawn) and bool(graphs))
    points = {marker.ns: len(marker.points) for marker in drawn[-1].markers if marker.action == Marker.ADD}
    assert points["meet_points"] + points["boundary_points"] == len(graphs[-1].nodes)
    assert points["edges"] == 2 * len(graphs[-1].edges)
    assert points["landmarks"] > 0


def test_markers_follow_the_atlas(staged: Staged) -> None:
    pair = staged(Pair)
    pair.rest.open_actions()
    drawn: list[MarkerArray] = []
    pair.rest.create_subscription(MarkerArray, "atlas/markers", drawn.append, LATCHED)
    pair.explore(3)
    edges = 2 * len(pair.atlas._server.state.graph.edges)
    assert edges > 0
    pair.spin_until(lambda: bool(drawn) and len(drawn[-1].markers[0].points) == edges)


def test_who_asks_for_no_old_messages_is_shown_the_markers_too(staged: Staged) -> None:
    """As RViz does; another has seen them before, and nothing happens meanwhile."""
    pair = staged(Pair)
    pair.rest.open_actions()
    pair.explore(3)
    first: list[MarkerArray] = []
    late: list[MarkerArray] = []
    pair.rest.create_subscription(MarkerArray, "atlas/markers", first.append, LATCHED)
    pair.spin_until(lambda: bool(first))
    pair.rest.create_subscription(MarkerArray, "atlas/markers", late.append, 10)
    pair.spin_until(lambda: bool(late))
    assert late[-1].markers[0].points
