"""Values of a world's YAML: each is what it must be, or one line says which key is wrong and how."""

import re
import reprlib
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from hslam_sim.world import WorldError

FARTHEST_M = 10_000.0
"""No coordinate and no length of a world is beyond it; a floor of that size is a slip of the pen."""
NAME = re.compile(r"\w[\w .()+-]{0,99}")


class Section:
    """One mapping of a world's YAML: the file as a whole, a corridor, a feature."""

    def __init__(self, content: Any, place: str, known: Collection[str]) -> None:
        """``place`` names the section in errors, "" for the whole file.

        Raises WorldError if there is no mapping or it has a key that is not ``known``; any name will do if none is.
        """
        self.place = place
        """May be set to a better name once it is read."""
        if not isinstance(content, Mapping):
            keys = ", ".join(known) or "names"
            raise WorldError(f"{place or 'the file'} must be a mapping of {keys}, not {shown(content)}")
        self._content: Mapping[Any, Any] = content
        for key in content:
            if known and key not in known:
                raise WorldError(f"{self._prefix}unknown key {shown(key)}; known are: {', '.join(sorted(known))}")
            check_name(key, self.place)

    def __contains__(self, key: str) -> bool:
        return self._content.get(key) is not None

    def at(self, key: str) -> str:
        """Return how errors name a key."""
        return self._prefix + key

    @property
    def _prefix(self) -> str:
        return f"{self.place}: " if self.place else ""

    def __iter__(self) -> Iterator[str]:
        return iter(self._content)

    def value(self, key: str) -> Any:
        """Return what is given for a key; raises WorldError if nothing is."""
        if key not in self:
            raise WorldError(f"{self._prefix}'{key}' is missing")
        return self._content[key]

    def number(self, key: str, least: float = -FARTHEST_M, most: float = FARTHEST_M) -> float:
        """Return a number from ``least`` to ``most``."""
        return number(self.value(key), self.at(key), least, most)

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text; ``default``, where there is one, if none is given."""
        value = self._content.get(key, default) if default else self.value(key)
        if not isinstance(value, str) or not value:
            raise WorldError(f"{self.at(key)} must be text, not {shown(value)}")
        return value

    def flag(self, key: str) -> bool:
        """Return true or false; false if not given."""
        value = self._content.get(key, False)
        if not isinstance(value, bool):
            raise WorldError(f"{self.at(key)} must be true or false, not {shown(value)}")
        return value

    def items(self, key: str) -> list[tuple[str, Any]]:
        """Return the items of a list, each with how errors name it; none if not given."""
        value = self._content.get(key, [])
        if not isinstance(value, list | tuple):
            raise WorldError(f"{self.at(key)} must be a list, not {shown(value)}")
        return [(f"{self.at(key)}[{index}]", item) for index, item in enumerate(value)]

    def section(self, key: str, known: Collection[str] = ()) -> "Section":
        """Return the mapping of a key, empty if not given."""
        return Section(self._content.get(key, {}), self.at(key), known)


def check_name(value: Any, place: str) -> None:
    """Raise WorldError unless a value can name something, a file too: nothing in it leads to another folder."""
    if not isinstance(value, str) or not NAME.fullmatch(value):
        raise WorldError(f"{place or 'the file'}: {shown(value)} is no name of letters, digits, spaces and ._()+-")


def number(value: Any, place: str, least: float = -FARTHEST_M, most: float = FARTHEST_M) -> float:
    """Return a value as a number from ``least`` to ``most``; text of one will do, as it does for map_server."""
    try:
        found = float("nan") if isinstance(value, bool) else float(value)
    except OverflowError:
        found = float("inf")
    except (TypeError, ValueError):
        raise WorldError(f"{place} must be a number, not {shown(value)}") from None
    if not least <= found <= most:
        raise WorldError(f"{place} must be a number from {least:g} to {most:g}, not {shown(value)}")
    return found


def numbers(value: Any, place: str, meaning: str) -> list[float]:
    """Return a list of as many numbers as ``meaning`` ("[x, y] in metres") names."""
    count = meaning.count(",") + 1
    if not isinstance(value, list | tuple) or len(value) != count:
        raise WorldError(f"{place} must be {meaning}, not {shown(value)}")
    return [number(item, f"{place}[{index}]") for index, item in enumerate(value)]


def shown(value: Any) -> str:
    """Return a value as an error shows it: one line, and not a long one."""
    return reprlib.repr(value)
