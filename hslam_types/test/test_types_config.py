"""Configurations refuse what they cannot mean, naming the parameter."""

import math
from dataclasses import dataclass
from typing import Any

import pytest

from hslam_types.config import Configuration, parameter
from hslam_types.errors import ConfigurationError


@dataclass(frozen=True)
class Gates(Configuration):
    """A small configuration."""

    accept: float = parameter(9.0, "gate of acceptance", low=0.0, high=100.0)
    looks: int = parameter(3, "looks before a landmark counts", low=1, high=10)
    name: str = parameter("plain", "what it is called")


def test_a_mapping_over_the_defaults() -> None:
    assert Gates.from_mapping({"accept": 4, "looks": 5}) == Gates(4, 5, "plain")


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"accept": -0.1}, "accept"),
        ({"accept": math.nan}, "accept"),
        ({"accept": "9"}, "accept"),
        ({"looks": 11}, "looks"),
        ({"looks": 2.0}, "looks"),
        ({"looks": True}, "looks"),
        ({"speed": 1.0}, "speed"),
    ],
)
def test_a_bad_value_is_refused_by_name(values: dict[str, Any], named: str) -> None:
    with pytest.raises(ConfigurationError, match=f"'{named}'"):
        Gates.from_mapping(values)
