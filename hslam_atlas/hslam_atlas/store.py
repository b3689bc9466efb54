"""The atlas file: one SQLite database, written as the atlas grows, read as far as it is asked for.

Everything a step changes is one transaction, so a file left by a killed process is the atlas as of its last
arrival.  Nothing is written before that: a file that is only opened is not changed, whatever is in it.
"""

import json
import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

from hslam_atlas.errors import ContentError, StoreError
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.missions.destination import Destination
from hslam_atlas.places import to_json
from hslam_atlas.questions import Question
from hslam_atlas.schema import TABLES, VERSION
from hslam_atlas.store_content import (
    check_tables,
    read_counts,
    read_graph,
    read_map,
    read_meta,
    read_places,
    read_questions,
)
from hslam_atlas.store_file import beside, close_whole, connect_to_read, connect_to_write, transaction
from hslam_atlas.store_rows import write_graph, write_maps, write_questions
from hslam_atlas.stored_maps import StoredMaps
from hslam_atlas.table_row import layout
from hslam_types.edge_map import EdgeMap


class AtlasStore(StoredMaps):
    """An atlas file, or, without a path, the same in memory: its edge-maps by edge, its graph and questions."""

    def __init__(self, path: Path | None = None, *, create: bool = True, write: bool = True) -> None:
        """Open, or create unless told not to; raises StoreError where the file is not an atlas of this version.

        A file of something else is left as it is.  Without ``write`` see `reading`.
        """
        super().__init__()
        self._path = path
        self._may_write = write
        self._is_writing = False
        create = create and write
        with self._told("cannot be opened as an atlas"):
            if path is None or (create and not (path.exists() and path.stat().st_size)):
                self._create()
            elif not path.exists():
                raise StoreError(f"{path}: no such file")
            else:
                self._db = connect_to_read(path)
        try:
            self._check()
            if write:
                self._check_permission()
        except StoreError:
            self._db.close()
            raise

    @classmethod
    def reading(cls, path: Path) -> Self:
        """Open an atlas as it is now, to read alone: nothing is created or changed, whoever writes it meanwhile."""
        return cls(path, write=False)

    def _create(self) -> None:
        if self._path is None:
            self._db = sqlite3.connect(":memory:", isolation_level=None)
        else:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._db = connect_to_write(self._path, create=True)
        self._is_writing = True
        try:
            self._db.executescript(TABLES)
        except sqlite3.Error:
            self._db.close()
            raise

    def _check(self) -> None:
        """Check that the database is an atlas."""
        with self._told("cannot be opened as an atlas"):
            named = {"key", "value"} <= set(layout(self._db, "meta").columns)
            version = read_meta(self._db, "version") if named else None
            if version is None:
                raise StoreError(f"{self._path} is not an atlas")
            if version.values["value"] != str(VERSION):
                raise version.broken("value", f"is another version than {VERSION}, which this program reads")
            check_tables(self._db)

    def _check_permission(self) -> None:
        """Find out at the start, not at the first arrival, that an atlas may not be written."""
        if self._path is not None and not (os.access(self._path, os.W_OK) and os.access(self._path.parent, os.W_OK)):
            raise StoreError(f"{self._path}: may not be written (nor files beside it, which a writer needs)")

    @contextmanager
    def _told(self, what: str) -> Iterator[None]:
        """Turn what SQLite, the file system and the content are to blame for into a StoreError: ``what`` failed."""
        try:
            yield
        except (sqlite3.Error, OSError, ContentError) as error:
            raise StoreError(f"{self._path or 'atlas in memory'}: {what} ({error})") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close; what was not saved is lost. One file remains, unless somebody else has it open."""
        if self._is_writing:
            close_whole(self._db)
        else:
            self._db.close()

    def save(self, graph: AtlasGraph, questions: list[Question], counts: Mapping[str, int]) -> None:
        """Write what has changed since the last time, all open questions and the counts, as one transaction.

        Raises StoreError if that cannot be, now: nothing is written then, and the next save will write it.
        """
        with self._told("cannot be written"):
            self._open_to_write()
            with transaction(self._db):
                write_graph(self._db, graph)
                write_maps(self._db, self._unsaved)
                write_questions(self._db, questions)
                self._set_meta("next_ids", json.dumps(graph.next_ids()))
                self._set_meta("counts", json.dumps(counts, sort_keys=True))
        self._unsaved.clear()
        graph.changed_nodes.clear()
        graph.changed_edges.clear()
        graph.changed_links.clear()

    def load(self) -> tuple[AtlasGraph, list[Question]]:
        """Return graph and open questions; the maps stay where they are until asked for.

        Raises StoreError, which names table and row, unless everything in the file can be read.
        """
        with self._told("cannot be read"):
            graph = read_graph(self._db)
            return graph, read_questions(self._db, graph)

    def counts(self) -> dict[str, int]:
        """Return the counts last saved, empty for a new atlas."""
        with self._told("cannot be read"):
            return read_counts(self._db)

    def places(self) -> dict[str, Destination]:
        """Return the places that have a name."""
        with self._told("cannot be read"):
            return read_places(self._db)

    def save_places(self, places: Mapping[str, Destination]) -> None:
        """Write the places that have a name, in place of those before; raises StoreError."""
        with self._told("cannot be written"):
            self._open_to_write()
            with transaction(self._db):
                self._set_meta("places", json.dumps(to_json(places)))

    def save_as(self, path: Path) -> None:
        """Write a copy of what was saved, in place of what is there; raises StoreError if that cannot be."""
        if self._path is not None and path.resolve() == self._path.resolve():
            raise StoreError(f"{path} is the atlas itself, which is saved at every arrival")
        if any(other.exists() for other in beside(path)):  # they would be taken for the copy's
            raise StoreError(f"{path} is being written, or was when its process was killed; choose another name")
        partial = path.parent / f"{path.name}.part"
        with self._told(f"cannot be copied to {path}"):
            try:
                with closing(sqlite3.connect(partial)) as copy:
                    self._db.backup(copy)
                    copy.execute("PRAGMA journal_mode = DELETE")
                partial.replace(path)
            finally:
                partial.unlink(missing_ok=True)

    def dump(self) -> Iterator[str]:
        """Yield the whole content as SQL, the same lines for the same atlas."""
        yield from self._db.iterdump()

    def _open_to_write(self) -> None:
        if self._is_writing or self._path is None:
            return
        if not self._may_write:
            raise StoreError(f"{self._path}: cannot be written (it was opened to read)")
        db = connect_to_write(self._path)
        self._db.close()
        self._db, self._is_writing = db, True

    def _read_map(self, edge_id: int) -> EdgeMap | None:
        """See `StoredMaps`."""
        with self._told("cannot be read"):
            return read_map(self._db, edge_id)

    def _set_meta(self, key: str, value: str) -> None:
        self._db.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, value))
