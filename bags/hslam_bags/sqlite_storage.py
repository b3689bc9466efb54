"""Reading an SQLite file as rosbag2 writes it (.db3)."""

import sqlite3
from collections.abc import Collection, Iterator
from pathlib import Path

from hslam_bags.errors import BagError
from hslam_bags.qos import qos_from_yaml
from hslam_bags.stored import Complaint, StoredMessage, StoredTopic


class SqliteStorage:
    """One .db3 file, opened read-only."""

    def __init__(self, path: Path, complain: Complaint) -> None:
        """Open ``path``; BagError if nothing of it can be read."""
        self.path = path
        self._complain = complain
        self._topics: dict[int, StoredTopic] = {}
        if not path.is_file():
            raise BagError(path, "", "cannot be read: no such file")
        if path.stat().st_size == 0:
            raise BagError(path, "", "is empty")
        try:
            self._database = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
            self._read_topics()
            self._counts = dict(self._database.execute("SELECT topic_id, count(*) FROM messages GROUP BY topic_id"))
            low, high = self._database.execute("SELECT min(timestamp), max(timestamp) FROM messages").fetchone()
        except (sqlite3.Error, ValueError, TypeError) as error:
            raise BagError(path, "", f"is no bag, or a damaged one: {error}") from error
        self.span_ns: tuple[int, int] | None = None if low is None else (low, high)

    @property
    def topics(self) -> tuple[StoredTopic, ...]:
        """The topics, in the order they were added."""
        return tuple(self._topics[key] for key in sorted(self._topics))

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic."""
        totals = dict.fromkeys((topic.name for topic in self.topics), 0)
        for key, topic in self._topics.items():
            totals[topic.name] += int(self._counts.get(key, 0))
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
                    self._complain(BagError(self.path, f"message {row_id}", "has no time or no bytes"))
                elif key in wanted:
                    yield StoredMessage(wanted[key].name, wanted[key].type_name, data, stamp_ns, stamp_ns)
        except (sqlite3.Error, ValueError) as error:
            self._complain(BagError(self.path, f"after message {last}", str(error)))

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
            definitions = {name: (encoding, text) for name, encoding, text in self._database.execute(query)}
        cursor = self._database.execute("SELECT * FROM topics")
        names = [column[0] for column in cursor.description]
        for row in cursor:
            topic = dict(zip(names, row, strict=True))
            self._read_topic(topic, definitions.get(topic["type"], ("", "")))

    def _read_topic(self, topic: dict[str, str], definition: tuple[str, str]) -> None:
        """Keep a topic whose messages are CDR."""
        place = f"topic {topic['name']}"
        if topic.get("serialization_format", "cdr") != "cdr":
            self._complain(BagError(self.path, place, f"messages are '{topic['serialization_format']}', not cdr"))
            return
        try:
            offers = qos_from_yaml(topic.get("offered_qos_profiles", ""))
        except ValueError as error:
            self._complain(BagError(self.path, place, str(error)))
            offers = ()
        type_hash = topic.get("type_description_hash", "")
        self._topics[int(topic["id"])] = StoredTopic(topic["name"], topic["type"], offers, type_hash, *definition)
