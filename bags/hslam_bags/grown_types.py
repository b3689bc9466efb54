"""Messages of types that have grown since they were recorded.

The suite adds fields to its messages at the end alone, and so that zero means what there was before. CDR writes one
field after the other, so zeros behind an older message are those fields; what is left over no reader looks at.
"""

from collections.abc import Iterable
from typing import Any

from rclpy.serialization import deserialize_message

from hslam_bags.definitions import SEPARATOR, DefinitionSource
from hslam_bags.message_types import message_class
from hslam_bags.stored import StoredMessage, StoredTopic

ROOM = bytes(256)
"""More than any type has grown by."""


def has_grown(stored: str, installed: str) -> bool:
    """Return whether a type's installed definition is the stored one with more fields at its end.

    Both are whole schemas. The types that the stored one holds must be as they were: inside a message nothing can grow.
    """
    old, new = _fields(stored), _fields(installed)
    known, now = old.pop(""), new.pop("")
    held = all(new.get(name) == fields for name, fields in old.items())
    return held and len(known) < len(now) and now[: len(known)] == known


class Decoder:
    """Decodes the messages of a bag."""

    def __init__(self, topics: Iterable[StoredTopic]) -> None:
        """Take the topics of the bag."""
        self._stored = {topic.type_name: topic.definition for topic in topics}
        self._installed = DefinitionSource()
        self._types: dict[str, tuple[Any, bytes]] = {}

    def decode(self, message: StoredMessage) -> Any:
        """Return a message as it is installed here; LookupError for a type that is not."""
        if message.type_name not in self._types:
            stored = self._stored.get(message.type_name, "")
            grown = bool(stored) and has_grown(stored, self._installed.find(message.type_name).text)
            self._types[message.type_name] = message_class(message.type_name), ROOM if grown else b""
        kind, room = self._types[message.type_name]
        return deserialize_message(message.raw + room, kind)


def _fields(schema: str) -> dict[str, list[str]]:
    """Return the lines of each type in a schema without comments and spacing, by its name; the type itself by ""."""
    own, *held = schema.split(SEPARATOR)
    texts = {"": own} | dict(text.strip().split("\n", 1) for text in held if "\n" in text.strip())
    lines = {name: (line.split("#", 1)[0].split() for line in text.splitlines()) for name, text in texts.items()}
    return {name: [" ".join(words) for words in split if words] for name, split in lines.items()}
