"""Message definitions as a bag stores them, read from the installed interface packages."""

import json
import os
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

SEPARATOR = "=" * 80

_INTEGERS = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
_PRIMITIVES = _INTEGERS | {"bool", "byte", "char", "float32", "float64", "string", "wstring"}
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{,99}/msg/[A-Za-z][A-Za-z0-9_]{,99}")
_TYPE = re.compile(r"^(?P<base>[A-Za-z][A-Za-z0-9_/]*)(?:<=\d+)?(?:\[[^\]]*\])?$")


class Definition(NamedTuple):
    """A type's whole schema: its own text and that of every type it holds, as rosbag2 and MCAP concatenate them."""

    name: str
    encoding: str
    text: str
    type_hash: str
    stamped: bool
    """The first field is a std_msgs/Header, so the stamp is found in bytes 4 to 12 of the CDR."""


class DefinitionSource:
    """Finds definitions below the prefixes of an ament index (apt and colcon installs, and the wheels' environment)."""

    def __init__(self, prefixes: Sequence[Path] | None = None) -> None:
        """Search ``prefixes`` in order; by default AMENT_PREFIX_PATH and the running Python's own prefix."""
        if prefixes is None:
            listed = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
            prefixes = [Path(entry) for entry in listed if entry] + [Path(sys.prefix)]
        self._prefixes = tuple(prefixes)
        self._found: dict[str, Definition] = {}

    def find(self, type_name: str) -> Definition:
        """Return the definition of a type such as ``nav_msgs/msg/Odometry``; LookupError says what is not installed."""
        if type_name not in self._found:
            self._found[type_name] = self._read(type_name)
        return self._found[type_name]

    def _read(self, type_name: str) -> Definition:
        parts = type_name.split("/")
        if not _NAME.fullmatch(type_name):
            raise LookupError(f"'{type_name}' is no message type; one looks like nav_msgs/msg/Odometry")
        root = (parts[0], parts[2])
        texts = {root: self._text(root)}
        pending = [root]
        while pending:
            owner = pending.pop(0)
            for held in field_types(owner[0], texts[owner]):
                if held not in texts:
                    texts[held] = self._text(held)
                    pending.append(held)
        whole = texts[root] + "".join(
            f"\n{SEPARATOR}\nMSG: {package}/{name}\n{text}"
            for (package, name), text in texts.items()
            if (package, name) != root
        )
        first = next(field_types(parts[0], texts[root], primitives=True), None)
        return Definition(type_name, "ros2msg", whole, self._hash(root), first == ("std_msgs", "Header"))

    def _file(self, package: str, name: str, ending: str) -> Path | None:
        paths = (prefix / "share" / package / "msg" / f"{name}{ending}" for prefix in self._prefixes)
        return next((path for path in paths if path.is_file()), None)

    def _text(self, key: tuple[str, str]) -> str:
        path = self._file(*key, ".msg")
        if path is None:
            searched = ", ".join(str(prefix) for prefix in self._prefixes)
            raise LookupError(
                f"no definition of {key[0]}/msg/{key[1]} below {searched}; is its package built and sourced?"
            )
        return path.read_text(encoding="utf-8").rstrip("\n") + "\n"

    def _hash(self, key: tuple[str, str]) -> str:
        """Return the RIHS01 type hash the build wrote beside the definition; empty where a build wrote none."""
        path = self._file(*key, ".json")
        if path is None:
            return ""
        wanted = f"{key[0]}/msg/{key[1]}"
        entries = json.loads(path.read_text(encoding="utf-8")).get("type_hashes", [])
        return next((str(entry["hash_string"]) for entry in entries if entry["type_name"] == wanted), "")


def field_types(package: str, text: str, *, primitives: bool = False) -> Iterator[tuple[str, str]]:
    """Yield (package, name) of each field's type in order, no constants; primitives as ("", name) if asked for."""
    for line in text.splitlines():
        words = line.split("#", 1)[0].split()
        # The first word is a type; a constant has its "=" after the name, a bounded type its "<=" in the first word.
        if len(words) < 2 or (match := _TYPE.match(words[0])) is None:
            continue
        if words[1].partition("=")[1] or (len(words) > 2 and words[2].startswith("=")):
            continue
        base = match["base"]
        if base in _PRIMITIVES:
            if primitives:
                yield "", base
        elif base == "Header":
            yield "std_msgs", "Header"
        else:
            *owner, name = base.split("/")
            yield (owner[0] if owner else package), name
