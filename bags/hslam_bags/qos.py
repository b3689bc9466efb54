"""Quality of service as a bag stores it, so that a replay offers what the recorded publisher offered."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from hslam_types.yaml_text import YamlError, load_yaml

INFINITE_NS = 2**63 - 1
"""How rmw writes "no limit" for deadline, lifespan and lease duration."""

_DEEPEST = 2**31 - 1
"""DDS counts a history's depth in 32 bits."""

_HISTORY = ("system_default", "keep_last", "keep_all", "unknown")
_RELIABILITY = ("system_default", "reliable", "best_effort", "unknown", "best_available")
_DURABILITY = ("system_default", "transient_local", "volatile", "unknown", "best_available")
_LIVELINESS = ("system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown", "best_available")


class OfferedQos(NamedTuple):
    """One publisher's offer, in the words of rosbag2's metadata version 9 (Jazzy); durations in nanoseconds."""

    history: str = "keep_last"
    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline_ns: int = INFINITE_NS
    lifespan_ns: int = INFINITE_NS
    liveliness: str = "automatic"
    lease_ns: int = INFINITE_NS


LATCHED = OfferedQos(depth=1, durability="transient_local")
"""A map-like topic: who joins late still gets the last message."""


def qos_to_yaml(offers: tuple[OfferedQos, ...], indent: str = "") -> str:
    """Return the YAML sequence rosbag2 version 9 stores, each line after ``indent``, without a final newline."""
    lines = []
    for offer in offers:
        lines += [
            f"- history: {offer.history}",
            f"  depth: {offer.depth}",
            f"  reliability: {offer.reliability}",
            f"  durability: {offer.durability}",
            *_time("deadline", offer.deadline_ns),
            *_time("lifespan", offer.lifespan_ns),
            f"  liveliness: {offer.liveliness}",
            *_time("liveliness_lease_duration", offer.lease_ns),
            "  avoid_ros_namespace_conventions: false",
        ]
    return "\n".join(indent + line for line in lines)


def _time(name: str, value_ns: int) -> tuple[str, str, str]:
    """Return the three YAML lines of a duration."""
    return (f"  {name}:", f"    sec: {value_ns // 10**9}", f"    nsec: {value_ns % 10**9}")


def qos_from_yaml(stored: Any) -> tuple[OfferedQos, ...]:
    """Read what any rosbag2 version stored: a sequence or its text, in words or rmw's numbers; else ValueError."""
    try:
        entries = load_yaml(stored) if isinstance(stored, str) else stored
    except YamlError as error:
        raise ValueError(f"offered_qos_profiles is not YAML: {error}") from error
    if entries is None or entries in ("", []):
        return ()
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        raise ValueError("offered_qos_profiles is not a list of profiles")
    return tuple(_offer(entry) for entry in entries)


def _offer(entry: Mapping[str, Any]) -> OfferedQos:
    """Read one profile; what is missing takes rmw's default, as older bags lack some fields."""
    return OfferedQos(
        history=_word(entry.get("history", 1), _HISTORY),
        depth=_whole(entry, "depth", 10, _DEEPEST),
        reliability=_word(entry.get("reliability", 1), _RELIABILITY),
        durability=_word(entry.get("durability", 2), _DURABILITY),
        deadline_ns=_duration(entry.get("deadline")),
        lifespan_ns=_duration(entry.get("lifespan")),
        liveliness=_word(entry.get("liveliness", 1), _LIVELINESS),
        lease_ns=_duration(entry.get("liveliness_lease_duration")),
    )


def _word(value: Any, words: tuple[str, ...]) -> str:
    """Return the policy's word for rmw's number or for the word itself."""
    if type(value) is int and 0 <= value < len(words):
        return words[value]
    return value.lower() if isinstance(value, str) and value.lower() in words else "unknown"


def _duration(value: Any) -> int:
    """Return nanoseconds; rmw's two ways of saying "none" (0 and the largest) both mean no limit."""
    if not isinstance(value, Mapping):
        return INFINITE_NS
    total = _whole(value, "sec", 0) * 10**9 + _whole(value, "nsec", 0)
    return min(total, INFINITE_NS) if total else INFINITE_NS


def _whole(entry: Mapping[str, Any], name: str, default: int, most: int = INFINITE_NS) -> int:
    """Return a whole number that is at least 0; ValueError names anything else."""
    value = entry.get(name, default)
    if type(value) is not int or not 0 <= value <= most:
        shown = repr(value)
        raise ValueError(f"offered_qos_profiles: '{name}' is no whole number up to {most}: {shown[:40]}")
    return value
