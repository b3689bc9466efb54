"""The atlas file: round trip, interruption, damage."""

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from corridor_floor import furnish, wean_hall
from edge_walker import EdgeWalker, WalkNoise
from explored import explore
from test_atlas_alignment import drives

from hslam_atlas import edge_map_blob
from hslam_atlas.errors import ContentError, StoreError
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore


def test_edge_map_survives_as_bytes_exactly() -> None:
    (edge_map,) = drives(1, 7)
    back = edge_map_blob.decode(edge_map_blob.encode(edge_map))
    np.testing.assert_array_equal(back.landmarks, edge_map.landmarks)
    lower = np.tril_indices(len(edge_map.covariance))
    np.testing.assert_array_equal(back.covariance[lower], edge_map.covariance[lower])
    np.testing.assert_array_equal(back.covariance, back.covariance.T)
    for name in ("traversal", "arrival", "terminal_x", "sightings", "departure_heading", "arrival_heading",
                 "robot_at_arrival", "path_length_m"):  # fmt: skip
        assert getattr(back, name) == getattr(edge_map, name)


def test_cut_bytes_are_refused() -> None:
    (edge_map,) = drives(1, 7)
    blob = edge_map_blob.encode(edge_map)
    for length in (0, 20, len(blob) - 1):
        with pytest.raises(ContentError, match="is no edge-map"):
            edge_map_blob.decode(blob[:length])


def run(store: AtlasStore, goals: int) -> AtlasServer:
    floor = furnish(wean_hall(), np.random.default_rng(1000))
    return explore(floor, 0, 0, WalkNoise(), goals=goals, store=store).server


def test_atlas_read_back_is_the_atlas_written(tmp_path: Path) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        server = run(store, 14)
        lines = list(store.dump())
        graph = server.state.graph
    with AtlasStore(tmp_path / "atlas.db") as again:
        assert list(again.dump()) == lines
        back = AtlasServer(store=again)
        assert sorted(back.state.graph.nodes) == sorted(graph.nodes)
        assert back.state.graph.next_ids() == graph.next_ids()
        for edge_id, edge in graph.edges.items():
            read = back.state.graph.edges[edge_id]
            assert read.traversals == edge.traversals
            assert [end[:2] for end in read.ends] == [end[:2] for end in edge.ends]
            np.testing.assert_array_equal(read.ends[0].frame_in_node.covariance, edge.ends[0].frame_in_node.covariance)
            assert again.get(edge_id).size > 0
        assert {q.node for q in back.questions.open} == {q.node for q in server.questions.open}


@pytest.mark.parametrize("seed", range(3))
def test_whatever_the_atlas_writes_it_reads(seed: int) -> None:
    """At any time: with links, questions, nodes passed unnoticed, branches invented, edges taken apart."""
    noise = WalkNoise(node_missed=0.4, degree_misread=0.3)
    walker = EdgeWalker(furnish(wean_hall(), np.random.default_rng(1000)), 0, np.random.default_rng(seed), noise)
    with AtlasStore() as store:
        server = AtlasServer(store=store)
        goal = server.step((), (), ()).goal
        asked = linked = 0
        for _ in range(25):
            assert goal is not None
            for step in walker.follow(goal):
                goal = server.step(step.events, step.edge_maps, step.links).goal
                graph, questions = store.load()
                asked, linked = asked + len(questions), linked + len(graph.links)
                assert graph.next_ids() == server.state.graph.next_ids()
        assert asked
        assert linked


def test_maps_are_read_when_asked_for(tmp_path: Path) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        run(store, 8)
    with AtlasStore(tmp_path / "atlas.db") as again:
        server = AtlasServer(store=again)
        assert not again._cache
        edge_id = min(server.state.graph.edges)
        assert again.seen_from(edge_id, 1).terminal_x == again.get(edge_id).terminal_x
        assert len(again._cache) == 2


def test_copy_is_the_same_atlas(tmp_path: Path) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        run(store, 6).save_as(tmp_path / "copy.db")
        with AtlasStore(tmp_path / "copy.db") as copy:
            assert list(copy.dump()) == list(store.dump())


def test_bad_files_are_named(tmp_path: Path) -> None:
    junk = tmp_path / "junk.db"
    junk.write_bytes(b"this is no database at all, but long enough to be looked at" * 20)
    with pytest.raises(StoreError, match=r"junk\.db: cannot be opened as an atlas"):
        AtlasStore(junk)
    AtlasStore(tmp_path / "new.db").close()
    change(tmp_path / "new.db", "UPDATE meta SET value = '99' WHERE key = 'version'")
    with pytest.raises(StoreError, match="'99' is another version"):
        AtlasStore(tmp_path / "new.db")
    with pytest.raises(StoreError, match="cannot be opened"):
        AtlasStore(tmp_path)


@pytest.mark.parametrize("table", ["addresses (name TEXT)", "meta (key TEXT PRIMARY KEY, value TEXT)"])
def test_another_programs_database_is_refused_and_left_as_it_is(tmp_path: Path, table: str) -> None:
    path = tmp_path / "other.db"
    change(path, f"CREATE TABLE {table}")
    before = path.read_bytes()
    with pytest.raises(StoreError, match=r"other\.db is not an atlas"):
        AtlasStore(path)
    assert path.read_bytes() == before


def test_only_an_atlas_is_opened_where_none_shall_be_created(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match=r"none\.db: no such file"):
        AtlasStore(tmp_path / "none.db", create=False)
    (tmp_path / "empty.db").touch()
    with pytest.raises(StoreError, match=r"empty\.db is not an atlas"):
        AtlasStore(tmp_path / "empty.db", create=False)
    assert [path.name for path in tmp_path.iterdir()] == ["empty.db"]
    assert (tmp_path / "empty.db").stat().st_size == 0


def test_a_copy_onto_the_atlas_itself_is_refused(tmp_path: Path) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        server = run(store, 6)
        with pytest.raises(StoreError, match="the atlas itself"):
            server.save_as(tmp_path / "sub" / ".." / "atlas.db")
        lines = list(store.dump())
    with AtlasStore(tmp_path / "atlas.db", create=False) as again:
        assert list(again.dump()) == lines


def test_a_copy_that_fails_leaves_the_old_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = tmp_path / "copy.db"
    old.write_bytes(b"precious")

    def fail(*_: object) -> None:
        raise OSError("no space left")

    with AtlasStore() as store:
        monkeypatch.setattr(Path, "replace", fail)
        with pytest.raises(StoreError, match=r"copied to .*copy\.db \(no space left\)"):
            store.save_as(old)
    assert old.read_bytes() == b"precious"
    assert [path.name for path in tmp_path.iterdir()] == ["copy.db"]


def change(path: Path, statement: str) -> None:
    """Do something to a database behind the store's back."""
    with closing(sqlite3.connect(path)) as db:
        db.execute(statement)
        db.commit()
