"""Writing the atlas file: readers stop nobody, what fails is told and written later, what is closed is one file."""

import os
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from recorded_drive import MAPPING, learnt, recorded, tell

from hslam_atlas.errors import StoreError
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore

STEPS = recorded()
HALF = len(STEPS) // 2


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@contextmanager
def held(path: Path, how: str) -> Iterator[sqlite3.Connection]:
    """Hold the file as another process may: in the middle of reading it, or of writing."""
    with closing(sqlite3.connect(path, isolation_level=None, timeout=0.0)) as db:
        db.execute(how)
        db.execute("SELECT count(*) FROM nodes").fetchone()
        yield db


def test_one_plain_file_remains(tmp_path: Path) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        tell(AtlasServer(MAPPING, store), STEPS)
        assert files(tmp_path) == ["atlas.db", "atlas.db-shm", "atlas.db-wal"]
    assert files(tmp_path) == ["atlas.db"]
    with AtlasStore.reading(tmp_path / "atlas.db") as again:
        assert tuple(again.dump()) == learnt()


def test_an_atlas_that_is_only_opened_is_not_changed(tmp_path: Path) -> None:
    path = tmp_path / "atlas.db"
    with AtlasStore(path) as store:
        tell(AtlasServer(MAPPING, store), STEPS)
    before = path.read_bytes()
    with AtlasStore(path) as again:
        AtlasServer(MAPPING, again).step((), (), ())
        assert files(tmp_path) == ["atlas.db"]
    assert path.read_bytes() == before


def test_a_reader_stops_no_writer_and_keeps_what_it_reads(tmp_path: Path) -> None:
    path = tmp_path / "atlas.db"
    with AtlasStore(path) as store:
        server = tell(AtlasServer(MAPPING, store), STEPS[:HALF])
        with held(path, "BEGIN") as reader:
            nodes = reader.execute("SELECT count(*) FROM nodes").fetchone()
            for step in STEPS[HALF:]:
                tell(server, (step,))
                assert server.unsaved is None
            assert reader.execute("SELECT count(*) FROM nodes").fetchone() == nodes
            assert tuple(store.dump()) == learnt()
            store.close()
            assert path.exists()
        with AtlasStore.reading(path) as again:
            assert tuple(again.dump()) == learnt()


@pytest.mark.parametrize("how", ["BEGIN", "BEGIN IMMEDIATE"])
def test_a_file_that_is_held_from_the_start_is_written_when_it_is_free(tmp_path: Path, how: str) -> None:
    path = tmp_path / "atlas.db"
    AtlasStore(path).close()
    store = AtlasStore(path)
    server = AtlasServer(MAPPING, store)
    with held(path, how):
        tell(server, STEPS[:HALF])
        assert "atlas.db: cannot be written (database is locked)" in str(server.unsaved)
        with pytest.raises(StoreError, match="is locked"):
            server.save_as(tmp_path / "copy.db")
    tell(server, STEPS[HALF:])
    assert server.unsaved is None
    store.close()
    with AtlasStore.reading(path) as again:
        assert tuple(again.dump()) == learnt()


@pytest.mark.parametrize("more_pages", [0, 1, 5])
def test_a_full_disk_costs_nothing_that_was_learnt(tmp_path: Path, more_pages: int) -> None:
    path = tmp_path / "atlas.db"
    store = AtlasStore(path)
    server = tell(AtlasServer(MAPPING, store), STEPS[:HALF])
    saved = tuple(store.dump())
    (pages,) = store._db.execute("PRAGMA page_count").fetchone()
    store._db.execute(f"PRAGMA max_page_count = {pages + more_pages}")
    tell(server, STEPS[HALF:])
    assert "disk is full" in str(server.unsaved)
    if not more_pages:
        assert tuple(store.dump()) == saved, "half a step is no step"
    for edge_id in server.state.graph.edges:
        assert store.get(edge_id).size > 0, "what is not in the file yet is there all the same"
    store._db.execute("PRAGMA max_page_count = 100000")
    server.save()
    store.close()
    with AtlasStore.reading(path) as again:
        assert tuple(again.dump()) == learnt()


def test_a_map_taken_out_while_nothing_can_be_written_stays_out(tmp_path: Path) -> None:
    path = tmp_path / "atlas.db"
    with AtlasStore(path) as store:
        server = tell(AtlasServer(MAPPING, store), STEPS)
        edge_id = max(server.state.graph.edges)
        server.state.graph.remove_edge(edge_id)
        server.state.maps.drop(edge_id)
        for end in (0, 1):
            with pytest.raises(StoreError, match=f"edge {edge_id} has no map"):
                store.seen_from(edge_id, end)
        server.save()
    with AtlasStore.reading(path) as again:
        assert edge_id not in again.load()[0].edges
        with pytest.raises(StoreError, match=f"edge {edge_id} has no map"):
            again.get(edge_id)


KILLED = """
import os, signal, sys
from pathlib import Path
from recorded_drive import MAPPING, recorded, tell
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
store = AtlasStore(Path(sys.argv[1]))
server = tell(AtlasServer(MAPPING, store), recorded()[:-1])
print(*store.dump(), sep="\\n", end="", flush=True)
left = [int(sys.argv[2])]
def count(statement):
    left[0] -= 1
    if not left[0] or (left[0] < 0 and statement == "COMMIT"):
        os.kill(os.getpid(), signal.SIGKILL)
store._db.set_trace_callback(count)
tell(server, recorded()[-1:])
"""


@pytest.mark.parametrize("statement", [2, 9, 0])
def test_a_process_killed_while_it_writes_leaves_the_atlas_as_it_was(tmp_path: Path, statement: int) -> None:
    """Killed at a statement of the last arrival's transaction, or at its COMMIT."""
    path = tmp_path / "atlas.db"
    here = str(Path(__file__).parent)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((here, os.environ.get("PYTHONPATH", "")))}
    killed = subprocess.run(
        [sys.executable, "-c", KILLED, str(path), str(statement)],
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    assert "CREATE TABLE" in killed.stdout
    with AtlasStore.reading(path) as reader:
        assert "\n".join(reader.dump()) == killed.stdout
    with AtlasStore(path) as writer:
        assert "\n".join(writer.dump()) == killed.stdout
        AtlasServer(MAPPING, writer).save()
    assert files(tmp_path) == ["atlas.db"]


@pytest.mark.parametrize("ending", ["-wal", "-journal"])
def test_no_copy_is_laid_beside_what_another_file_has_left(tmp_path: Path, ending: str) -> None:
    """SQLite would take the leftover for the copy's own newest pages."""
    (tmp_path / f"copy.db{ending}").write_bytes(b"of another file")
    with AtlasStore() as store, pytest.raises(StoreError, match=r"copy\.db is being written, or was"):
        store.save_as(tmp_path / "copy.db")
    assert files(tmp_path) == [f"copy.db{ending}"]


def test_a_copy_of_an_atlas_under_way_is_one_plain_file(tmp_path: Path) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        tell(AtlasServer(MAPPING, store), STEPS).save_as(tmp_path / "copy.db")
        assert [name for name in files(tmp_path) if name.startswith("copy")] == ["copy.db"]
        with AtlasStore.reading(tmp_path / "copy.db") as copy:
            assert tuple(copy.dump()) == learnt()
        assert [name for name in files(tmp_path) if name.startswith("copy")] == ["copy.db"]


def test_a_file_that_may_not_be_written_is_told_at_the_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    AtlasStore(tmp_path / "atlas.db").close()
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(StoreError, match=r"atlas\.db: may not be written"):
        AtlasStore(tmp_path / "atlas.db")
    AtlasStore.reading(tmp_path / "atlas.db").close()
