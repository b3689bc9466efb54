"""The atlas file: one SQLite database, written as the atlas grows, read as far as it is asked for.

Everything a step changes is one transaction, so a file left by a killed process is the atlas as of its last
arrival.  Edge-maps, the bulk, are read when needed and few are kept in memory.
"""

import json
import sqlite3
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

from hslam_atlas import edge_map_blob
from hslam_atlas.errors import StoreError
from hslam_atlas.graph import AtlasGraph
from hslam_atlas.questions import Question
from hslam_atlas.schema import TABLES, VERSION
from hslam_atlas.store_file import connect_to_read
from hslam_atlas.store_rows import read_graph, read_questions, write_graph, write_questions
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse

_MAPS_KEPT = 64


class AtlasStore:
    """An atlas file, or, without a path, the same in memory."""

    def __init__(self, path: Path | None = None, *, create: bool = True, write: bool = True) -> None:
        """Open, or create unless told not to; raises StoreError where the file is not an atlas of this version.

        A file of something else is left as it is.  Without ``write`` see `reading`.
        """
        self._path = path
        self._cache: OrderedDict[tuple[int, int], EdgeMap] = OrderedDict()
        create = create and write
        if path is not None and not create and not path.is_file():
            raise StoreError(f"{path}: no such file")
        with self._told("cannot be opened as an atlas"):
            if path is not None and create:
                path.parent.mkdir(parents=True, exist_ok=True)
            if path is not None and not write:
                self._db = connect_to_read(path)
            else:
                self._db = sqlite3.connect(str(path) if path is not None else ":memory:")
        try:
            self._take_up(create=create)
        except StoreError:
            self._db.close()
            raise

    @classmethod
    def reading(cls, path: Path) -> Self:
        """Open an atlas as it is now, to read alone: nothing is created or changed, whoever writes it meanwhile."""
        return cls(path, write=False)

    def _take_up(self, *, create: bool) -> None:
        """Check that the database is an atlas; make one of an empty one."""
        with self._told("cannot be opened as an atlas"):
            tables = {name for (name,) in self._db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
            if create and not tables:
                self._db.executescript(TABLES)
                return
            version = self.meta("version") if "meta" in tables else None
        if version is None:
            raise StoreError(f"{self._path} is not an atlas")
        if version != str(VERSION):
            raise StoreError(f"{self._path}: an atlas of version {version}; this program reads version {VERSION}")

    @contextmanager
    def _told(self, what: str) -> Iterator[None]:
        """Turn what SQLite and the file system complain of into a StoreError that says ``what`` failed."""
        try:
            yield
        except (sqlite3.Error, OSError) as error:
            raise StoreError(f"{self._path or 'atlas in memory'}: {what} ({error})") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close; what was not saved is lost: a step that failed half-way leaves no trace."""
        self._db.close()

    # Edge-maps

    def get(self, edge_id: int) -> EdgeMap:
        """Return the stored map, in the frame of the edge's first end; raises StoreError if there is none."""
        return self.seen_from(edge_id, 0)

    def seen_from(self, edge_id: int, end: int) -> EdgeMap:
        """Return the map with its origin at the given end (0 or 1); raises StoreError if there is none."""
        known = self._cache.get((edge_id, end))
        if known is None:
            if end == 0:
                with self._told("cannot be read"):
                    row = self._db.execute("SELECT map FROM edge_maps WHERE edge = ?", (edge_id,)).fetchone()
                if row is None:
                    raise StoreError(f"edge {edge_id} has no map")
                known = edge_map_blob.decode(row[0])
            else:
                known = reverse(self.seen_from(edge_id, 0))
            self._keep(edge_id, end, known)
        self._cache.move_to_end((edge_id, end))
        return known

    def put(self, edge_id: int, edge_map: EdgeMap) -> None:
        """Store or replace an edge's map, with the next `save`."""
        row = (edge_id, edge_map_blob.encode(edge_map))
        with self._told("cannot be written"):
            self._db.execute("INSERT OR REPLACE INTO edge_maps VALUES (?, ?)", row)
        self._cache.pop((edge_id, 1), None)
        self._keep(edge_id, 0, edge_map)

    def drop(self, edge_id: int) -> None:
        """Forget an edge's map, with the next `save`."""
        with self._told("cannot be written"):
            self._db.execute("DELETE FROM edge_maps WHERE edge = ?", (edge_id,))
        for end in (0, 1):
            self._cache.pop((edge_id, end), None)

    def _keep(self, edge_id: int, end: int, edge_map: EdgeMap) -> None:
        self._cache[edge_id, end] = edge_map
        while len(self._cache) > _MAPS_KEPT:
            self._cache.popitem(last=False)

    # Graph

    def save(self, graph: AtlasGraph, questions: list[Question], counts: Mapping[str, int]) -> None:
        """Write what has changed since the last time, all open questions and the counts, as one transaction."""
        with self._told("cannot be written"):
            write_graph(self._db, graph)
            write_questions(self._db, questions)
            self.set_meta("next_ids", json.dumps(graph.next_ids()))
            self.set_meta("counts", json.dumps(counts, sort_keys=True))
            self._db.commit()
        graph.changed_nodes.clear()
        graph.changed_edges.clear()
        graph.changed_links.clear()

    def load(self) -> tuple[AtlasGraph, list[Question]]:
        """Return graph and open questions; the maps stay where they are until asked for."""
        with self._told("cannot be read"):
            graph, questions = read_graph(self._db), read_questions(self._db)
        next_ids = self.meta("next_ids")
        graph.resume(json.loads(next_ids) if next_ids else [0, 0, 0])
        return graph, questions

    def counts(self) -> dict[str, int]:
        """Return the counts last saved, empty for a new atlas."""
        counts: dict[str, int] = json.loads(self.meta("counts") or "{}")
        return counts

    # The rest

    def meta(self, key: str) -> str | None:
        """Return a value kept by name, None if there is none."""
        with self._told("cannot be read"):
            row = self._db.execute("SELECT value FROM meta WHERE key = ?", (key,)).fetchone()
        return None if row is None else str(row[0])

    def set_meta(self, key: str, value: str) -> None:
        """Keep a value by name, with the next `save`."""
        with self._told("cannot be written"):
            self._db.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, value))

    def save_as(self, path: Path) -> None:
        """Write a copy of what was saved, in place of what is there; raises StoreError if that cannot be."""
        if self._path is not None and path.resolve() == self._path.resolve():
            raise StoreError(f"{path} is the atlas itself, which is saved at every arrival")
        partial = path.parent / f"{path.name}.part"
        with self._told(f"cannot be copied to {path}"):
            try:
                with closing(sqlite3.connect(str(partial))) as copy:
                    self._db.backup(copy)
                partial.replace(path)
            finally:
                partial.unlink(missing_ok=True)

    def dump(self) -> Iterator[str]:
        """Yield the whole content as SQL, the same lines for the same atlas."""
        yield from self._db.iterdump()
