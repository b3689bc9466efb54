"""The atlas file as SQLite opens it: to read alone, changing nothing, whatever its writer does or has left."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

_BESIDE = ("-wal", "-journal")
"""What SQLite keeps beside a file whose newest changes are not all in it, or not all out of it."""


def connect_to_read(path: Path) -> sqlite3.Connection:
    """Return a connection to the file as it is now, until closed; neither it nor its folder is changed.

    Raises sqlite3.Error or OSError if that cannot be.
    """
    path = path.resolve()
    shared = path.with_name(f"{path.name}-shm").exists()  # by this index readers and a writer keep apart
    if any(path.with_name(path.name + ending).exists() for ending in _BESIDE) and not shared:
        return _recovered(path)
    # Without an index SQLite would make one to read a file of write-ahead mode: where no writer is, none is needed.
    how = "immutable=1" if _is_write_ahead(path) and not shared else "mode=ro"
    db = sqlite3.connect(f"{path.as_uri()}?{how}", uri=True, isolation_level=None)
    try:
        db.execute("BEGIN")
        db.execute("SELECT count(*) FROM sqlite_master")  # the first look fixes what all later ones see
    except sqlite3.Error:
        db.close()
        raise
    return db


def _is_write_ahead(path: Path) -> bool:
    """Whether the file's header asks for write-ahead mode (https://www.sqlite.org/fileformat2.html, offset 18)."""
    with path.open("rb") as file:
        return file.read(20)[18:] == b"\x02\x02"


def _recovered(path: Path) -> sqlite3.Connection:
    """Return in memory what a killed process left, its unfinished step undone: SQLite would do that in the file."""
    db = sqlite3.connect(":memory:", isolation_level=None)
    with TemporaryDirectory() as folder:
        for ending in ("", *_BESIDE):
            beside = path.with_name(path.name + ending)
            if beside.exists():
                shutil.copyfile(beside, Path(folder) / f"atlas.db{ending}")
        with closing(sqlite3.connect(Path(folder) / "atlas.db")) as copy:
            copy.backup(db)
    return db
