"""The atlas file: round trip, interruption, damage."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
from corridor_floor import furnish, wean_hall
from edge_walker import WalkNoise
from test_atlas_alignment import drives
from test_atlas_exploration import explore

from hslam_atlas import edge_map_blob
from hslam_atlas.errors import StoreError
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
        with pytest.raises(StoreError, match="edge-map"):
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


def test_file_of_a_killed_process_is_whole(tmp_path: Path) -> None:
    """What was not committed is lost, what was is readable: as if killed in the middle of a step."""
    path = tmp_path / "atlas.db"
    store = AtlasStore(path)
    server = run(store, 8)
    nodes = len(server.state.graph.nodes)
    store.set_meta("half", "done")  # a transaction begun and never committed
    with sqlite3.connect(path) as other:
        assert other.execute("SELECT count(*) FROM nodes").fetchone() == (nodes,)
        assert other.execute("SELECT count(*) FROM meta WHERE key = 'half'").fetchone() == (0,)
    other.close()
    store.close()


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
    with AtlasStore(tmp_path / "new.db") as store:
        store.set_meta("version", "99")
    with pytest.raises(StoreError, match="version 99"):
        AtlasStore(tmp_path / "new.db")
    with pytest.raises(StoreError, match="cannot be opened"):
        AtlasStore(tmp_path)
