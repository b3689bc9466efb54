"""Rows of an atlas file as they are read: each value is what its column must hold, or is refused by its place."""

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from typing import Any

from hslam_atlas import pose_blob
from hslam_atlas.errors import ContentError
from hslam_atlas.schema import LARGEST, TABLES
from hslam_atlas.uncertain_pose import UncertainPose

LAST_ID = 2**31 - 1
"""Largest id or count: messages hold no more."""
LAST_NUMBER = 2**63 - 1
"""Largest number of an event, or time (ns)."""
_LONGEST = 40
"""Letters of a broken value that are repeated in the error."""


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of a table, and those of them that name a row."""

    columns: tuple[str, ...]
    key: tuple[str, ...]


@cache
def layouts() -> Mapping[str, Layout]:
    """Return how the tables of this version look, by name."""
    with closing(sqlite3.connect(":memory:")) as db:
        db.executescript(TABLES)
        names = [name for (name,) in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        return {name: layout(db, name) for name in names}


def layout(db: sqlite3.Connection, table: str) -> Layout:
    """Return how a table of a database looks, without columns if there is none."""
    found = [(name, key) for name, key in db.execute("SELECT name, pk FROM pragma_table_info(?)", (table,))]
    keys = sorted((number, name) for name, number in found if number)
    return Layout(tuple(name for name, _ in found), tuple(name for _, name in keys))


def rows(db: sqlite3.Connection, table: str) -> Iterator["TableRow"]:
    """Yield a table's rows in the order of their keys; raises ContentError, which names it, if that cannot be."""
    looks = layouts()[table]
    query = f"SELECT {', '.join(looks.columns)} FROM {table} ORDER BY {', '.join(looks.key)}"  # noqa: S608 - the schema's
    try:
        for values in db.execute(query):
            yield TableRow(table, looks.key, dict(zip(looks.columns, values, strict=True)))
    except sqlite3.Error as error:
        raise ContentError(f"table {table}: {error}") from error


@dataclass(frozen=True, slots=True)
class TableRow:
    """One row; what it returns is sound, or ContentError names table, row and column."""

    table: str
    key: tuple[str, ...]
    values: Mapping[str, Any]

    def broken(self, column: str, what: str) -> ContentError:
        """Return the error that says ``what`` is wrong with a value of this row."""
        name = ", ".join(f"{part} {_shown(self.values[part])}" for part in self.key)
        return ContentError(f"table {self.table}, row {name}: {column} = {_shown(self.values[column])} {what}")

    def integer(self, column: str, low: int = 0, high: int = LAST_ID) -> int:
        """Return a whole number from ``low`` to ``high``."""
        value = self.values[column]
        if not isinstance(value, int) or not low <= value <= high:
            raise self.broken(column, f"is no whole number from {low} to {high}")
        return value

    def real(self, column: str, low: float = -LARGEST) -> float:
        """Return a number from ``low`` to `LARGEST`."""
        value = self.values[column]
        if not isinstance(value, int | float) or not low <= value <= LARGEST:
            raise self.broken(column, f"is no number from {low:g} to {LARGEST:g}")
        return value

    def text(self, column: str) -> str:
        """Return a text."""
        value = self.values[column]
        if not isinstance(value, str):
            raise self.broken(column, "is no text")
        return value

    def blob(self, column: str) -> bytes:
        """Return bytes."""
        value = self.values[column]
        if not isinstance(value, bytes):
            raise self.broken(column, "is no blob")
        return value

    def pose(self, column: str) -> UncertainPose:
        """Return a pose with its covariance."""
        try:
            return pose_blob.decode(self.blob(column))
        except ContentError as error:
            raise self.broken(column, str(error)) from error

    def from_json(self, column: str) -> Any:
        """Return what a JSON text holds."""
        try:
            return json.loads(self.text(column))
        except (ValueError, RecursionError) as error:
            raise self.broken(column, "is no JSON") from error

    def integers(self, column: str) -> tuple[int, ...]:
        """Return a JSON list of whole numbers that are not negative."""
        values = self.from_json(column)
        if not isinstance(values, list) or not all(is_count(value) for value in values):
            raise self.broken(column, "is no list of whole numbers")
        return tuple(values)

    def reals(self, column: str) -> tuple[float, ...]:
        """Return a JSON list of numbers."""
        values = self.from_json(column)
        if not isinstance(values, list) or not all(
            isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST for value in values
        ):
            raise self.broken(column, "is no list of numbers")
        return tuple(values)

    def pairs(self, column: str) -> frozenset[tuple[int, int]]:
        """Return a JSON list of pairs of ids."""
        values = self.from_json(column)
        if not isinstance(values, list) or not all(
            isinstance(pair, list) and len(pair) == 2 and all(is_count(value) for value in pair) for pair in values
        ):
            raise self.broken(column, "is no list of pairs of ids")
        return frozenset((a, b) for a, b in values)


def is_count(value: object) -> bool:
    """Whether something read from JSON is a whole number that counts or names something."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= LAST_NUMBER


def _shown(value: object) -> str:
    """Return a value in one short line, as SQL says it."""
    if value is None:
        return "NULL"
    if isinstance(value, bytes):
        return f"blob of {len(value)} bytes"
    shown = ascii(value)
    return shown if len(shown) <= _LONGEST else f"{shown[:_LONGEST]}..."
