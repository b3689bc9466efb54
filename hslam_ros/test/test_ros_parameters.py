"""A configuration becomes ROS parameters in one loop, and a bad value is refused at the start."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

from hslam_ros.parameters import declare, refuse_unknown
from hslam_types.config import Configuration, parameter
from hslam_types.errors import ConfigurationError


@dataclass(frozen=True)
class Gates(Configuration):
    """A small configuration."""

    accept: float = parameter(9.0, "gate", low=0.0, high=100.0, unit="1")
    looks: int = parameter(3, "looks before a landmark counts", low=1, high=10)
    quick: bool = parameter(False, "hurry")


@pytest.fixture
def context() -> Iterator[rclpy.Context]:
    own = rclpy.Context()
    rclpy.init(context=own)
    yield own
    own.try_shutdown()


def started_with(context: rclpy.Context, **values: Any) -> Node:
    overrides = [Parameter(f"gates.{name}", value=value) for name, value in values.items()]
    return Node("parameters_test", context=context, parameter_overrides=overrides)


def test_defaults_come_from_the_dataclass(context: rclpy.Context) -> None:
    assert declare(started_with(context), Gates, "gates.") == Gates()


def test_overrides_reach_the_dataclass_and_the_descriptor_tells_the_meaning(context: rclpy.Context) -> None:
    node = started_with(context, accept=4.0, looks=5, quick=True)
    assert declare(node, Gates, "gates.") == Gates(4.0, 5, True)
    descriptor = node.describe_parameter("gates.accept")
    assert descriptor.description == "gate [1]"
    assert descriptor.floating_point_range[0].to_value == 100.0


@pytest.mark.parametrize("bad", [{"accept": 101.0}, {"accept": float("nan")}, {"looks": 0}, {"accept": "wide"}])
def test_a_bad_value_is_refused_with_its_name(context: rclpy.Context, bad: dict[str, Any]) -> None:
    node = started_with(context, **bad)
    with pytest.raises(ConfigurationError, match=f"gates.{next(iter(bad))}"):
        declare(node, Gates, "gates.")


def test_a_whole_number_does_for_a_real_one(context: rclpy.Context) -> None:
    node = started_with(context, accept=4)
    assert declare(node, Gates, "gates.") == Gates(4.0)
    assert node.get_parameter("gates.accept").value == 4.0


def test_a_parameter_nobody_declared_is_refused_with_those_known(context: rclpy.Context) -> None:
    node = started_with(context, looks=5, look=7)
    declare(node, Gates, "gates.")
    with pytest.raises(
        ConfigurationError, match=r"unknown parameter 'gates\.look'; known are: gates\.accept, gates\.looks"
    ):
        refuse_unknown(node)
    refuse_unknown(Node("nothing_given", context=context))
