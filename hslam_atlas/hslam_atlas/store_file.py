"""The atlas file as SQLite opens it, to read or to write, so that neither ever waits for the other.

Written, a file is in write-ahead mode (https://www.sqlite.org/wal.html): what is new is in ``-wal`` beside it, its
index in ``-shm``, and readers keep the state they began with.  Closed, it is one plain file again.
"""

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

_BUSY_S = 0.2
"""How long a write waits for another process that holds the file: the robot waits too, and it is tried again later."""


def beside(path: Path) -> tuple[Path, Path, Path]:
    """Return what SQLite may keep beside a database: ``-wal``, ``-shm``, and ``-journal`` in the older mode."""
    wal, shm, journal = (path.with_name(path.name + ending) for ending in ("-wal", "-shm", "-journal"))
    return wal, shm, journal


def connect_to_read(path: Path) -> sqlite3.Connection:
    """Return a connection to the file as it is now, until closed; neither it nor its folder is changed.

    Raises sqlite3.Error or OSError if that cannot be.
    """
    path = path.resolve()
    wal, shm, _ = beside(path)
    if wal.exists() and not shm.exists():  # copied from a running robot, or its power failed
        return _recovered(path)
    # SQLite would make an index to read a file that was left in write-ahead mode; where nobody writes, none is needed.
    left_whole = not wal.exists() and _is_write_ahead(path)
    db = _connect(path, "immutable=1" if left_whole else "mode=ro")
    try:
        db.execute("BEGIN")
        db.execute("SELECT count(*) FROM sqlite_master")  # the first look fixes what all later ones see
    except sqlite3.Error as error:
        db.close()
        if error.sqlite_errorcode == sqlite3.SQLITE_READONLY_ROLLBACK:
            return _recovered(path)
        raise
    return db


def connect_to_write(path: Path, *, create: bool = False) -> sqlite3.Connection:
    """Return a connection to a file, which must be there unless it is to be made; raises sqlite3.Error."""
    return _connect(path.resolve(), "mode=rwc" if create else "mode=rw")


@contextmanager
def transaction(db: sqlite3.Connection) -> Iterator[None]:
    """Make what is written within one step, all of it or nothing; raises sqlite3.Error."""
    db.execute("PRAGMA journal_mode = WAL")
    db.execute("BEGIN IMMEDIATE")
    try:
        yield
        db.execute("COMMIT")
    finally:
        if db.in_transaction:
            db.execute("ROLLBACK")


def close_whole(db: sqlite3.Connection) -> None:
    """Close a connection that wrote: one plain file remains, or, while somebody reads it, the same in two."""
    with suppress(sqlite3.Error):
        db.execute("PRAGMA journal_mode = DELETE")
    db.close()


def _connect(path: Path, how: str) -> sqlite3.Connection:
    db = sqlite3.connect(f"{path.as_uri()}?{how}", uri=True, timeout=_BUSY_S, isolation_level=None)
    db.text_factory = _text
    return db


def _text(stored: bytes) -> str:
    """Return a text; what is none is shown by its bytes, for whoever checks the row to name it."""
    return stored.decode(errors="backslashreplace")


def _is_write_ahead(path: Path) -> bool:
    """Whether a file is in write-ahead mode: then, and only then, it cannot be opened without locks.

    To read the header would be simpler, but a process that closes a file loses its locks on it, SQLite's too.
    """
    with closing(_connect(path, "mode=ro&nolock=1")) as db:
        try:
            db.execute("SELECT count(*) FROM sqlite_master")
        except sqlite3.Error as error:
            return error.sqlite_errorcode == sqlite3.SQLITE_CANTOPEN
    return False


def _recovered(path: Path) -> sqlite3.Connection:
    """Return in memory what a killed process left, its unfinished step undone: SQLite would do that in the file."""
    db = sqlite3.connect(":memory:", isolation_level=None)
    db.text_factory = _text
    wal, _, journal = beside(path)
    with TemporaryDirectory() as folder:
        for source in (path, wal, journal):
            if source.exists():
                shutil.copyfile(source, Path(folder) / source.name)
        with closing(sqlite3.connect(Path(folder) / path.name)) as copy:
            copy.backup(db)
    return db
