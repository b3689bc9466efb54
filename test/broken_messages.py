"""Messages as nobody sane sends them: any field of a good one replaced, tables cut or lengthened, through CDR."""

import math
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

from builtin_interfaces.msg import Time
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

_REALS = st.sampled_from([math.nan, math.inf, -math.inf, 0.0, -1.0, 1e-300, 1e300, -1e300]) | st.floats()
_BITS = {"int8": 7, "uint8": 8, "int16": 15, "uint16": 16, "int32": 31, "uint32": 32, "int64": 63, "uint64": 64}


def through_cdr(msg: Any) -> Any:
    """Return the message as a listener gets it."""
    return deserialize_message(serialize_message(msg), type(msg))


@st.composite
def broken(draw: st.DrawFn, good: Any, most: int = 3) -> Any:
    """Return a copy of ``good`` with up to ``most`` of its fields, at any depth, replaced."""
    msg = deepcopy(good)
    for _ in range(draw(st.integers(1, most))):
        owner, name, kind = draw(st.sampled_from(list(_leaves(msg))))
        setattr(owner, name, draw(_replacement(kind, getattr(owner, name))))
    return through_cdr(msg)


def _leaves(msg: Any) -> Iterator[tuple[Any, str, str]]:
    """Yield every field that is no message: its owner, name and type."""
    for name, kind in msg.get_fields_and_field_types().items():
        value = getattr(msg, name)
        if hasattr(value, "get_fields_and_field_types"):
            yield from _leaves(value)
        else:
            yield msg, name, kind


@st.composite
def _replacement(draw: st.DrawFn, kind: str, value: Any) -> Any:
    if kind.startswith("sequence"):
        return draw(_table(kind.removeprefix("sequence<").removesuffix(">"), list(value)))
    if kind.endswith("]"):
        row = list(value)
        row[draw(st.integers(0, len(row) - 1))] = draw(_REALS)
        return row
    return draw(_scalar(kind))


@st.composite
def _table(draw: st.DrawFn, kind: str, rows: list[Any]) -> list[Any]:
    """Return rows with one replaced, or some cut off or added."""
    whole = draw(st.booleans())
    if rows and whole:
        rows[draw(st.integers(0, len(rows) - 1))] = draw(_scalar(kind))
        return rows
    return rows[: draw(st.integers(0, len(rows)))] + draw(st.lists(_scalar(kind), max_size=3))


def _scalar(kind: str) -> st.SearchStrategy[Any]:
    if kind in ("double", "float"):
        return _REALS if kind == "double" else st.floats(width=32)
    if kind in _BITS:
        most = 2 ** _BITS[kind] - 1
        return st.integers(0 if kind.startswith("u") else -most - 1, most)
    if kind == "boolean":
        return st.booleans()
    if kind == "string":
        return st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=8)
    if kind == "builtin_interfaces/Time":
        return st.builds(Time, sec=_scalar("int32"), nanosec=_scalar("uint32"))
    raise NotImplementedError(kind)
