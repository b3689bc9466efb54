"""The places of an atlas that somebody has given a name, as its file keeps them."""

from collections.abc import Mapping
from typing import Any

from hslam_atlas.missions.destination import AtNode, Destination, DestinationError, OnEdge

NAME_LENGTH = 100
"""Characters of a name at most."""


def check_name(name: str) -> str:
    """Return a name without spaces about it; raises DestinationError for what is none."""
    name = name.strip()
    if not name or len(name) > NAME_LENGTH or not name.isprintable():
        raise DestinationError(f"a place needs a printable name of 1 to {NAME_LENGTH} characters")
    return name


def to_json(places: Mapping[str, Destination]) -> dict[str, list[float]]:
    """Return places as JSON has them: [node], or [edge, distance, offset]."""
    return {
        name: [place.node] if isinstance(place, AtNode) else [place.edge, place.distance, place.offset]
        for name, place in sorted(places.items())
    }


def from_json(value: Any) -> dict[str, Destination] | None:
    """Return the places that JSON tells, None where it tells none.

    A place may be of a node or edge that the atlas no longer has: who goes there is told.
    """
    if not isinstance(value, dict):
        return None
    places: dict[str, Destination] = {}
    for name, numbers in value.items():
        if not isinstance(numbers, list) or not all(type(n) in (int, float) for n in numbers):
            return None
        if not numbers or type(numbers[0]) is not int or numbers[0] < 0 or len(numbers) not in (1, 3):
            return None
        where = [float(n) for n in numbers[1:]]
        places[name] = OnEdge(numbers[0], *where) if where else AtNode(numbers[0])
    return places
