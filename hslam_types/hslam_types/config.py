"""Configuration: frozen dataclasses whose fields carry unit, range and meaning, and which validate themselves.

A field is declared once, with ``parameter``; the ROS parameters, the YAML files and the tables of the
documentation are derived from it, so that no default exists twice.
"""

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, Self, cast

from hslam_types.errors import ConfigurationError


class Parameter(NamedTuple):
    """What is known of one configuration value."""

    name: str
    default: bool | int | float | str
    low: float
    high: float
    unit: str
    meaning: str
    changeable: bool = False
    """Whether it may be set anew while the node runs."""


def parameter(
    default: bool | float | str,
    meaning: str,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    unit: str = "",
    changeable: bool = False,
) -> Any:
    """Declare a field of a `Configuration` with its default, inclusive range, SI unit and meaning (with its source)."""
    about = {"low": low, "high": high, "unit": unit, "meaning": meaning, "changeable": changeable}
    return dataclasses.field(default=default, metadata=about)


@dataclasses.dataclass(frozen=True)
class Configuration:
    """Base of every component's configuration; subclasses are frozen dataclasses of `parameter` fields."""

    def __post_init__(self) -> None:
        """Check every value against its type and range; raises ConfigurationError."""
        for entry in self.parameters():
            check(entry, getattr(self, entry.name))

    @classmethod
    def parameters(cls) -> Iterator[Parameter]:
        """Yield every parameter in order of declaration."""
        for field in dataclasses.fields(cls):
            about, default = field.metadata, cast("bool | int | float | str", field.default)
            yield Parameter(
                field.name, default, about["low"], about["high"], about["unit"], about["meaning"], about["changeable"]
            )

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Self:
        """Build from a mapping such as a YAML file's; raises ConfigurationError on an unknown name or a bad value."""
        known = {entry.name for entry in cls.parameters()}
        for name in values:
            if name not in known:
                raise ConfigurationError(f"unknown parameter '{name}'; known are: {', '.join(sorted(known))}")
        return cls(**values)


def check(entry: Parameter, value: Any) -> None:
    """Raise ConfigurationError unless ``value`` has the parameter's type and lies in its range."""
    kind = type(entry.default)
    if type(value) is not kind and not (kind is float and type(value) is int):
        raise ConfigurationError(
            f"parameter '{entry.name}' must be of type {kind.__name__}, not {value!r} ({entry.meaning})"
        )
    if isinstance(value, int | float) and not entry.low <= value <= entry.high:
        raise ConfigurationError(
            f"parameter '{entry.name}' = {value} is outside [{entry.low}, {entry.high}] {entry.unit} ({entry.meaning})"
        )
