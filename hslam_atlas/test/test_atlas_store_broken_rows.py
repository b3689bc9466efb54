"""Whatever is in an atlas file: one line that names file, table and row, and nothing is changed in it."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from broken_rows import NUMBERED, Attack, atlas, attacks, broken

from hslam_atlas.errors import StoreError
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore

REFERRED = NUMBERED | {("branches", "key"), ("branches", "edge")}
"""A row that is called otherwise may be sound itself: the one that refers to it is named."""


def refused(path: Path) -> str:
    """Return what is said of a file, by whoever opens it to read and to write alike."""
    before = path.read_bytes()
    with pytest.raises(StoreError) as reading, AtlasStore.reading(path) as store:
        AtlasServer(store=store)
    with pytest.raises(StoreError) as writing, AtlasStore(path) as store:
        AtlasServer(store=store)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    assert str(reading.value) == str(writing.value)
    return str(reading.value)


def test_the_atlas_that_is_broken_below_is_whole(tmp_path: Path) -> None:
    path = atlas(tmp_path / "atlas.db")
    with closing(sqlite3.connect(path)) as db:
        tables = [name for (name,) in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        assert all(db.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in tables)  # noqa: S608
    with AtlasStore(path) as store:
        assert len(AtlasServer(store=store).state.graph.edges) == 1


@pytest.mark.parametrize("attack", tuple(attacks()), ids=str)
def test_a_broken_value_is_named_by_its_row(tmp_path: Path, attack: Attack) -> None:
    said = refused(broken(atlas(tmp_path / "atlas.db"), attack))
    assert said.startswith(f"{tmp_path}/atlas.db: cannot be ")
    assert "\n" not in said
    assert len(said) < 400
    assert ", row" in said or " has no row " in said
    if (attack.table, attack.column) not in REFERRED:
        assert attack.table in said


@pytest.mark.parametrize(
    ("change", "table"),
    [
        ("ALTER TABLE nodes ADD COLUMN colour TEXT", "nodes"),
        ("ALTER TABLE meta ADD COLUMN colour TEXT", "meta"),
        ("ALTER TABLE links RENAME COLUMN pose TO place", "links"),
        ("ALTER TABLE visits RENAME TO calls", "visits"),
        ("DROP TABLE questions", "questions"),
        ("CREATE TABLE others AS SELECT * FROM nodes; DROP TABLE nodes; ALTER TABLE others RENAME TO nodes", "nodes"),
        ("DELETE FROM edge_maps", "edge_maps"),
        ("DELETE FROM edges", "branches"),
        ("DELETE FROM meta WHERE key = 'next_ids'", "meta"),
        ("UPDATE edges SET traversals = CAST(X'22c3280a' AS TEXT)", "edges"),
    ],
)
def test_tables_of_another_shape_are_named(tmp_path: Path, change: str, table: str) -> None:
    path = atlas(tmp_path / "atlas.db")
    with closing(sqlite3.connect(path)) as db:
        db.executescript(change)
    said = refused(path)
    assert "\n" not in said
    assert "atlas.db" in said
    assert f"table {table}" in said


def test_a_reader_that_comes_to_a_broken_map_says_which(tmp_path: Path) -> None:
    path = atlas(tmp_path / "atlas.db")
    with AtlasStore.reading(path) as store:
        store.load()
        with closing(sqlite3.connect(":memory:")) as damaged:
            store._db.backup(damaged)
            damaged.execute("UPDATE edge_maps SET map = zeroblob(9)")
            store._db, whole = damaged, store._db
            with pytest.raises(StoreError, match=r"atlas\.db.*table edge_maps, row edge 0: map = blob of 9 bytes"):
                store.get(0)
            store._db = whole
