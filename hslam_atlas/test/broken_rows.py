"""A small atlas with a row in every table, and ways to break any value of it behind SQLite's back."""

import json
import math
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from test_atlas_alignment import drives

from hslam_atlas.graph import AtlasGraph, EdgeEnd
from hslam_atlas.questions import Question
from hslam_atlas.store import AtlasStore
from hslam_atlas.table_row import layouts
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2

POSE = UncertainPose.diagonal(SE2(3.0, 1.0, 0.5), 0.1, 0.01)
NUMBERED = {("nodes", "id"), ("edges", "id"), ("edge_maps", "edge"), ("links", "id")}
"""Columns in which SQLite keeps nothing but whole numbers."""
INTEGERS = {
    ("nodes", "id"): (-1, 99),
    ("nodes", "kind"): (0, 99),
    ("branches", "node"): (99,),
    ("branches", "key"): (-1, 99),
    ("branches", "edge"): (None, 99),
    ("branches", "seen"): (-1,),
    ("branches", "missed"): (2**40,),
    ("branches", "attempts"): (0.5,),
    ("branches", "given_up"): (2,),
    ("visits", "node"): (99,),
    ("visits", "sequence"): (-1,),
    ("visits", "stamp_ns"): (-1,),
    ("edges", "id"): (-1, 99),
    ("edges", "node0"): (1, 99),
    ("edges", "branch0"): (1, 99),
    ("edges", "node1"): (0, 99),
    ("edges", "branch1"): (1, 99),
    ("edge_maps", "edge"): (-1, 99),
    ("links", "id"): (-1, 99),
    ("links", "node0"): (99,),
    ("links", "node1"): (99,),
    ("questions", "node"): (99,),
    ("questions", "other"): (99,),
}
REALS = {
    ("nodes", "clearance"): (-1.0,),
    ("branches", "bearing"): (math.inf,),
    ("edges", "terminal_x"): (-math.inf,),
    ("edges", "terminal_variance"): (math.inf,),
    ("edges", "path_length"): (-1.0,),
    ("links", "path_length"): (-1.0,),
    ("questions", "place_evidence"): (1e300,),
}
BLOBS = {("edges", "frame0"), ("edges", "frame1"), ("edge_maps", "map"), ("links", "pose"), ("questions", "pose")}
NO_LIST = ("", "no JSON", "{}", "3", "[null]", '["a"]', "[NaN]", "[true]", f"[{'9' * 5000}]", "[" * 5000)
LISTS = {
    ("edges", "traversals"): (*NO_LIST, "[]", "[0.5]", "[-1]"),
    ("questions", "map_evidence"): (*NO_LIST, "[1e999]"),
    ("questions", "compared"): (*NO_LIST, "[1]", "[[1]]", "[[1, 2, 3]]", "[[1, -2]]"),
}
META = {
    "version": ("2", "", "one\ntwo"),
    "next_ids": (*NO_LIST, "[]", "[9, 9]", "[9, 9, 9, 9]", "[1, 9, 9]", "[9, 0, 9]", "[9, 9, 0]"),
    "counts": ("", "no JSON", "[]", '{"closures": null}', '{"closures": "a"}', '{"closures": -1}', "[" * 5000),
}


@dataclass(frozen=True)
class Attack:
    """A value in the place of what one column of a table's first row holds; bytes also by their length alone."""

    table: str
    column: str
    value: object
    name: str | None = None
    """Of the row, in the table of what is kept by name."""

    def __str__(self) -> str:
        """Return a short name."""
        return f"{self.table}.{self.name or self.column}={self.value!r:.20}"


def atlas(path: Path) -> Path:
    """Write an atlas to a file."""
    path.write_bytes(_whole())
    return path


@cache
def _whole() -> bytes:
    """Return the file of two nodes with an edge, a link and a question between them."""
    (edge_map,) = drives(1, 7)
    graph = AtlasGraph()
    for number in range(2):
        graph.add_node(NodeKind.MEET_POINT, 1.3, [0.0, 2.0]).visits.append((number, 10**9))
    ends = EdgeEnd(0, 0, POSE), EdgeEnd(1, 0, POSE)
    edge = graph.connect(ends, edge_map.terminal_x, 0.01, edge_map.path_length_m, edge_map.traversal)
    graph.add_link(0, 1, POSE, 4.0)
    question = Question(1, 0, POSE, 1.5, (2.0, 3.0), frozenset({(0, 5)}))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "atlas.db"
        with AtlasStore(path) as store:
            store.put(edge.id, edge_map)
            store.save(graph, [question], {"closures": 0, "compared": 4, "alike": 1})
        return path.read_bytes()


def broken(path: Path, attack: Attack) -> Path:
    """Break one value of an atlas file that SQLite would not let anybody break."""
    with closing(sqlite3.connect(path)) as db:
        db.execute("PRAGMA synchronous = OFF")
        db.execute("PRAGMA writable_schema = ON")
        db.execute("UPDATE sqlite_master SET sql = replace(sql, ' NOT NULL', '')")
        db.commit()
    key = layouts()[attack.table].key
    name = "" if attack.name is None else f" WHERE key = '{attack.name}'"
    first = f"SELECT {', '.join(key)} FROM {attack.table}{name} ORDER BY {', '.join(key)} LIMIT 1"  # noqa: S608
    change = f"UPDATE {attack.table} SET {attack.column} = ? WHERE ({', '.join(key)}) = ({first})"  # noqa: S608
    with closing(sqlite3.connect(path)) as db:
        db.execute("PRAGMA synchronous = OFF")
        assert db.execute(change, (attack.value,)).rowcount == 1
        db.commit()
    return path


def attacks() -> Iterator[Attack]:
    """Yield every column of every table with what it must not hold."""
    for table, layout in layouts().items():
        for column in layout.columns:
            yield from (Attack(table, column, value) for value in _wrong(table, column))
    for name, values in META.items():
        yield from (Attack("meta", "value", value, name) for value in (None, b"", *values))


def _wrong(table: str, column: str) -> Iterator[object]:
    place = table, column
    if table == "meta":
        return
    if place not in NUMBERED:
        yield from ("two\nlines", b"", b"\xff" * 96)
        if column not in layouts()[table].key:
            yield None
    if place in BLOBS:
        yield from (bytes(95), bytes(97), bytes(960), b"\xff" * 76, json.dumps([0.0] * 12))
        return
    yield from (INTEGERS | REALS | LISTS)[place]
