"""The atlas file: one SQLite database, written as the atlas grows, read as far as it is asked for.

Everything a step changes is one transaction, so a file left by a killed process is the atlas as of its last
arrival.  Edge-maps, the bulk, are read when needed and few are kept in memory.
"""

import json
import sqlite3
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from hslam_atlas import edge_map_blob
from hslam_atlas.errors import StoreError
from hslam_atlas.graph import AtlasGraph, Branch, Edge, EdgeEnd, Link, Node
from hslam_atlas.questions import Question
from hslam_atlas.schema import TABLES, VERSION
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

_MAPS_KEPT = 64


class AtlasStore:
    """An atlas file, or, without a path, the same in memory."""

    def __init__(self, path: Path | None = None) -> None:
        """Open or create; raises StoreError when the file is not an atlas or of another version."""
        self._cache: OrderedDict[tuple[int, int], EdgeMap] = OrderedDict()
        try:
            if path is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
            self._db = sqlite3.connect(str(path) if path is not None else ":memory:")
            self._db.executescript(TABLES)
        except (sqlite3.Error, OSError) as error:
            raise StoreError(f"{path}: cannot be opened as an atlas ({error})") from error
        version = self.meta("version")
        if version is not None and version != str(VERSION):
            raise StoreError(f"{path}: an atlas of version {version}; this program reads version {VERSION}")
        self.set_meta("version", str(VERSION))
        self._db.commit()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Commit and close; a second time does nothing harmful."""
        self._db.commit()
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
        self._db.execute("INSERT OR REPLACE INTO edge_maps VALUES (?, ?)", (edge_id, edge_map_blob.encode(edge_map)))
        self._cache.pop((edge_id, 1), None)
        self._keep(edge_id, 0, edge_map)

    def drop(self, edge_id: int) -> None:
        """Forget an edge's map, with the next `save`."""
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
        db = self._db
        for node_id in sorted(graph.changed_nodes):
            _write_node(db, node_id, graph.nodes.get(node_id))
        for edge_id in sorted(graph.changed_edges):
            _write_edge(db, edge_id, graph.edges.get(edge_id))
        for link_id in sorted(graph.changed_links):
            _write_link(db, link_id, graph.links.get(link_id))
        db.execute("DELETE FROM questions")
        for q in sorted(questions, key=lambda q: (q.node, q.other)):
            compared = json.dumps(sorted(q.compared))
            pose, maps = _pose_to_blob(q.node_in_other), json.dumps(q.map_evidence)
            row = (q.node, q.other, pose, q.place_evidence, maps, compared)
            db.execute("INSERT OR REPLACE INTO questions VALUES (?, ?, ?, ?, ?, ?)", row)
        self.set_meta("next_ids", json.dumps(graph.next_ids()))
        self.set_meta("counts", json.dumps(counts, sort_keys=True))
        db.commit()
        graph.changed_nodes.clear()
        graph.changed_edges.clear()
        graph.changed_links.clear()

    def load(self) -> tuple[AtlasGraph, list[Question]]:
        """Return graph and open questions; the maps stay where they are until asked for."""
        db, graph = self._db, AtlasGraph()
        for node_id, kind, clearance in db.execute("SELECT id, kind, clearance FROM nodes ORDER BY id"):
            graph.nodes[node_id] = Node(node_id, NodeKind(kind), clearance)
        for node_id, key, bearing, edge, seen, missed, attempts, given_up in db.execute(
            "SELECT * FROM branches ORDER BY node, key"
        ):
            branch = Branch(key, bearing, edge, seen, missed, attempts, bool(given_up))
            graph.nodes[node_id].branches[key] = branch
        for node_id, sequence, stamp_ns in db.execute("SELECT * FROM visits ORDER BY node, sequence"):
            graph.nodes[node_id].visits.append((sequence, stamp_ns))
        for row in db.execute("SELECT * FROM edges ORDER BY id"):
            graph.put_edge(_edge_from_row(row))
        for link_id, node0, node1, pose, length in db.execute("SELECT * FROM links ORDER BY id"):
            graph.put_link(Link(link_id, node0, node1, _pose_from_blob(pose), length))
        next_ids = self.meta("next_ids")
        graph.resume(json.loads(next_ids) if next_ids else [0, 0, 0])
        questions = [
            Question(
                node,
                other,
                _pose_from_blob(pose),
                place,
                tuple(json.loads(maps)),
                frozenset((a, b) for a, b in json.loads(compared)),
            )
            for node, other, pose, place, maps, compared in db.execute("SELECT * FROM questions ORDER BY node, other")
        ]
        return graph, questions

    def counts(self) -> dict[str, int]:
        """Return the counts last saved, empty for a new atlas."""
        counts: dict[str, int] = json.loads(self.meta("counts") or "{}")
        return counts

    # The rest

    def meta(self, key: str) -> str | None:
        """Return a value kept by name, None if there is none."""
        row = self._db.execute("SELECT value FROM meta WHERE key = ?", (key,)).fetchone()
        return None if row is None else str(row[0])

    def set_meta(self, key: str, value: str) -> None:
        """Keep a value by name, with the next `save`."""
        self._db.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, value))

    def save_as(self, path: Path) -> None:
        """Write a copy of the whole atlas; raises StoreError if that cannot be."""
        self._db.commit()
        try:
            path.unlink(missing_ok=True)
            with sqlite3.connect(str(path)) as copy:
                self._db.backup(copy)
            copy.close()
        except (sqlite3.Error, OSError) as error:
            raise StoreError(f"{path}: cannot be written ({error})") from error

    def dump(self) -> Iterator[str]:
        """Yield the whole content as SQL, the same lines for the same atlas."""
        yield from self._db.iterdump()


def _write_node(db: sqlite3.Connection, node_id: int, node: Node | None) -> None:
    for table, key in (("nodes", "id"), ("branches", "node"), ("visits", "node")):
        db.execute(f"DELETE FROM {table} WHERE {key} = ?", (node_id,))  # noqa: S608 - names from the line above
    if node is None:
        return
    db.execute("INSERT INTO nodes VALUES (?, ?, ?)", (node_id, int(node.kind), node.clearance_m))
    for b in node.branches.values():
        row = (node_id, b.key, b.bearing, b.edge, b.seen, b.missed, b.attempts, int(b.given_up))
        db.execute("INSERT INTO branches VALUES (?, ?, ?, ?, ?, ?, ?, ?)", row)
    for sequence, stamp_ns in node.visits:
        db.execute("INSERT INTO visits VALUES (?, ?, ?)", (node_id, sequence, stamp_ns))


def _write_edge(db: sqlite3.Connection, edge_id: int, edge: Edge | None) -> None:
    db.execute("DELETE FROM edges WHERE id = ?", (edge_id,))
    if edge is None:
        return
    ends = [value for end in edge.ends for value in (end.node, end.branch, _pose_to_blob(end.frame_in_node))]
    sizes = (edge.terminal_x, edge.terminal_variance, edge.path_length_m)
    row = (edge_id, *ends, *sizes, json.dumps(edge.traversals))
    db.execute("INSERT INTO edges VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", row)


def _edge_from_row(row: tuple[object, ...]) -> Edge:
    edge_id, n0, b0, f0, n1, b1, f1, terminal_x, variance, length, traversals = row
    ends = (EdgeEnd(n0, b0, _pose_from_blob(f0)), EdgeEnd(n1, b1, _pose_from_blob(f1)))  # type: ignore[arg-type]
    return Edge(edge_id, ends, terminal_x, variance, length, tuple(json.loads(traversals)))  # type: ignore[arg-type]


def _write_link(db: sqlite3.Connection, link_id: int, link: Link | None) -> None:
    db.execute("DELETE FROM links WHERE id = ?", (link_id,))
    if link is not None:
        row = (link_id, link.from_node, link.to_node, _pose_to_blob(link.to_in_from), link.path_length_m)
        db.execute("INSERT INTO links VALUES (?, ?, ?, ?, ?)", row)


def _pose_to_blob(pose: UncertainPose) -> bytes:
    return np.concatenate((np.array(pose.pose), pose.covariance.ravel())).astype("<f8").tobytes()


def _pose_from_blob(blob: bytes) -> UncertainPose:
    values = np.frombuffer(blob, "<f8")
    x, y, theta = values[:3].tolist()
    return UncertainPose(SE2(x, y, theta), values[3:].reshape(3, 3).astype(np.float64))
