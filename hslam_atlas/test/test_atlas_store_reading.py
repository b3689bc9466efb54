"""An atlas opened to read: never created, never changed, whatever its writer does or has left behind."""

import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from hslam_atlas.errors import StoreError
from hslam_atlas.store import AtlasStore


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.endswith("-shm")}


def atlas(path: Path) -> Path:
    with AtlasStore(path) as store:
        store.save(*store.load(), {"closures": 3})
    return path


def write_ahead(path: Path) -> sqlite3.Connection:
    """Change the file as a writer in write-ahead mode does; the change is beside the file as long as it is open."""
    db = sqlite3.connect(path)
    db.execute("PRAGMA journal_mode = WAL")
    db.execute("UPDATE meta SET value = '{\"closures\": 7}' WHERE key = 'counts'")
    db.commit()
    return db


@pytest.mark.parametrize("data", [b"", b"no database" * 500])
def test_what_is_no_atlas_does_not_become_one(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "some.db").write_bytes(data)
    with pytest.raises(StoreError, match=r"some\.db"):
        AtlasStore.reading(tmp_path / "some.db")
    with pytest.raises(StoreError, match=r"none\.db: no such file"):
        AtlasStore.reading(tmp_path / "none" / "none.db")
    assert content(tmp_path) == {"some.db": data}


def test_a_name_full_of_signs_is_that_file(tmp_path: Path) -> None:
    path = atlas(tmp_path / "a?mode=rwc#b%20c d.db")
    with AtlasStore.reading(path) as store:
        assert store.counts() == {"closures": 3}
    assert list(content(tmp_path)) == [path.name]


def test_nothing_can_be_written(tmp_path: Path) -> None:
    path = atlas(tmp_path / "atlas.db")
    before = content(tmp_path)
    with AtlasStore.reading(path) as store, pytest.raises(StoreError, match=r"atlas\.db: cannot be written"):
        store.save(*store.load(), {})
    assert content(tmp_path) == before


def test_a_reader_keeps_the_atlas_it_opened_while_it_is_written(tmp_path: Path) -> None:
    path = atlas(tmp_path / "atlas.db")
    with closing(write_ahead(path)) as writer:
        before = content(tmp_path)
        with AtlasStore.reading(path) as reader:
            assert content(tmp_path) == before
            assert reader.counts() == {"closures": 7}
            writer.execute("UPDATE meta SET value = '{\"closures\": 8}' WHERE key = 'counts'")
            writer.commit()
            assert reader.counts() == {"closures": 7}
        with AtlasStore.reading(path) as reader:
            assert reader.counts() == {"closures": 8}


def test_reading_a_file_does_not_cost_this_process_its_locks(tmp_path: Path) -> None:
    """As a plain open and close of the file would: the writer would go on with nothing to keep others out."""
    path = atlas(tmp_path / "atlas.db")
    with closing(sqlite3.connect(path)) as writer:
        writer.execute("BEGIN IMMEDIATE")
        AtlasStore.reading(path).close()
        other = f"import sqlite3; sqlite3.connect({str(path)!r}, timeout=0).execute('BEGIN IMMEDIATE')"
        refused = subprocess.run([sys.executable, "-c", other], capture_output=True, text=True, check=False)
    assert "database is locked" in refused.stderr


def left_whole(path: Path) -> int:
    """The last to close was one who may only read: the mode stays in the file, nothing is beside it."""
    write_ahead(path).close()
    return 7


def left_beside_without_index(path: Path) -> int:
    """Copied from a running robot: the newest changes are beside the file, the index is not."""
    with closing(write_ahead(path)):
        beside = {name: (path.parent / name).read_bytes() for name in (path.name, f"{path.name}-wal")}
    for name, data in beside.items():
        (path.parent / name).write_bytes(data)
    return 7


def left_in_mid_step(path: Path) -> int:
    """Killed in the middle of a transaction of the older mode: half of it is in the file already."""
    with closing(sqlite3.connect(path)) as db:
        db.execute("PRAGMA cache_size = 1")
        db.execute("PRAGMA cache_spill = 1")
        db.execute("UPDATE meta SET value = '{\"closures\": 9}' WHERE key = 'counts'")
        for number in range(200):
            db.execute("INSERT INTO edge_maps VALUES (?, zeroblob(4000))", (number,))
        beside = {name: (path.parent / name).read_bytes() for name in (path.name, f"{path.name}-journal")}
    for name, data in beside.items():
        (path.parent / name).write_bytes(data)
    return 3


@pytest.mark.parametrize("leave", [left_whole, left_beside_without_index, left_in_mid_step])
def test_what_a_writer_left_is_read_and_left(tmp_path: Path, leave: Callable[[Path], int]) -> None:
    path = atlas(tmp_path / "atlas.db")
    closures = leave(path)
    before = content(tmp_path)
    with AtlasStore.reading(path) as store:
        assert store.counts() == {"closures": closures}
        assert sorted(content(tmp_path)) == sorted(before)
    assert content(tmp_path) == before
    assert not list(tmp_path.glob("*-shm"))
