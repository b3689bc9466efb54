"""Reading an SQLite file as rosbag2 writes it (.db3)."""

import sqlite3
from collections.abc import Collection, Iterator
from pathlib import Path

from hslam_bags.errors import BagError
from hslam_bags.qos import qos_from_yaml
from hslam_bags.stored import Complaint, StoredMessage, StoredTopic

_COUNT = """
SELECT topic_id, sum(typeof(timestamp) = 'integer' AND timestamp >= 0), count(*) FROM messages GROUP BY topic_id
"""
_SPAN = """
SELECT min(timestamp), max(timestamp) FROM messages WHERE typeof(timestamp) = 'integer' AND timestamp >= 0
"""


class SqliteStorage:
    """One .db3 file, opened read-only."""

    def __init__(self, path: Path, complain: Complaint) -> None:
        """Open ``path``; BagError if nothing of it can be read."""
        self.path = path
        self._complain = complain
        self._topics: dict[int, StoredTopic] = {}
        self._refused: set[object] = set()
        if not path.is_file():
            raise BagError(path, "", "cannot be read: no such file")
        if path.stat().st_size == 0:
            raise BagError(path, "", "is empty")
        try:
            self._database = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
            self._database.text_factory = lambda raw: raw.decode("utf-8", "replace")
            self._read_topics()
            counts = self._database.execute(_COUNT).fetchall()
            low, high = self._database.execute(_SPAN).fetchone()
        except (sqlite3.Error, ValueError, TypeError) as error:
            raise BagError(path, "", f"is no bag, or a damaged one: {error}") from error
        self.span_ns: tuple[int, int] | None = None if low is None else (low, high)
        self._counts = {key: int(timely or 0) for key, timely, _ in counts}
        for key, timely, total in counts:
            place = f"topic {self._topics[key].name}" if key in self._topics else f"topic number {key}"
            if untimely := total - (timely or 0):
                complain(BagError(path, place, f"{untimely} messages have no time, or one before 0"))
            if key not in self._topics and key not in self._refused:
                complain(BagError(path, place, f"{total} messages are of no known topic"))

    @property
    def topics(self) -> tuple[StoredTopic, ...]:
        """The topics, in the order they were added."""
        return tuple(self._topics[key] for key in sorted(self._topics))

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic."""
        totals = dict.fromkeys((topic.name for topic in self.topics), 0)
        for key, topic in self._topics.items():
            totals[topic.name] += self._counts.get(key, 0)
        return totals

    def messages(self, topics: Collection[str], start_ns: int, end_ns: int) -> Iterator[StoredMessage]:
        """Yield the messages of ``topics`` with start <= log time < end, in order of log time."""
        wanted = {key: topic for key, topic in self._topics.items() if topic.name in topics}
        query = (
            "SELECT id, topic_id, timestamp, data FROM messages WHERE timestamp >= ? AND timestamp < ? "
            "ORDER BY timestamp, id"
        )
        last = 0
        try:
            for row_id, key, stamp_ns, data in self._database.execute(query, (start_ns, min(end_ns, 2**63 - 1))):
                last = row_id
                if not isinstance(stamp_ns, int) or not isinstance(data, bytes):
                    self._complain(BagError(self.path, f"message {row_id}", "is no bytes"))
                elif key in wanted:
                    yield StoredMessage(wanted[key].name, wanted[key].type_name, data, stamp_ns, stamp_ns)
        except (sqlite3.Error, ValueError) as error:
            self._complain(BagError(self.path, f"after message {last}", str(error)))

    def check(self) -> None:
        """Let SQLite look at its own pages."""
        try:
            (found,) = self._database.execute("PRAGMA integrity_check(1)").fetchone()
        except (sqlite3.Error, ValueError) as error:
            found = str(error)
        if found != "ok":
            self._complain(BagError(self.path, "", f"is damaged: {found}"))

    def close(self) -> None:
        """Close the database."""
        self._database.close()

    def _read_topics(self) -> None:
        """Read the topics; older layouts lack some columns and the table of definitions."""
        columns = {row[1] for row in self._database.execute("PRAGMA table_info(topics)")}
        if not {"id", "name", "type"} <= columns:
            raise BagError(self.path, "table topics", "is missing or lacks columns: this is no bag")
        definitions = {}
        if self._database.execute("SELECT 1 FROM sqlite_master WHERE name = 'message_definitions'").fetchone():
            query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            definitions = {
                name: (_text(encoding), _text(text)) for name, encoding, text in self._database.execute(query)
            }
        cursor = self._database.execute("SELECT * FROM topics")
        names = [column[0] for column in cursor.description]
        for row in cursor:
            topic = dict(zip(names, row, strict=True))
            self._read_topic(topic, definitions.get(topic["type"], ("", "")))

    def _read_topic(self, topic: dict[str, object], definition: tuple[str, str]) -> None:
        """Keep a topic that has a number, a name and a type, and whose messages are CDR."""
        key, name, type_name = topic["id"], topic["name"], topic["type"]
        if not isinstance(key, int) or not _text(name) or not _text(type_name):
            self._refused.add(key)
            self._complain(
                BagError(self.path, f"topic number {key}", f"has no name or no type: {name!r}, {type_name!r}")
            )
            return
        place = f"topic {name}"
        packing = topic.get("serialization_format", "cdr")
        if packing != "cdr":
            self._refused.add(key)
            self._complain(BagError(self.path, place, f"messages are '{packing}', not cdr"))
            return
        try:
            offers = qos_from_yaml(topic.get("offered_qos_profiles", ""))
        except ValueError as error:
            self._complain(BagError(self.path, place, str(error)))
            offers = ()
        type_hash = _text(topic.get("type_description_hash"))
        self._topics[key] = StoredTopic(_text(name), _text(type_name), offers, type_hash, *definition)


def _text(value: object) -> str:
    """Return a column's text, "" where it is something else."""
    return value if isinstance(value, str) else ""
