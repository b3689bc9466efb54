"""ROS parameters from configuration dataclasses: declared in one loop, with meaning, unit and range."""

import math
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from hslam_types.config import Configuration, Parameter, check
from hslam_types.errors import ConfigurationError

C = TypeVar("C", bound=Configuration)


def declare(node: Node, config_type: type[C], prefix: str = "") -> C:
    """Declare every parameter of ``config_type`` on the node and return the configuration it was started with.

    ``prefix`` (such as "sonar.") groups the parameters of one component. Raises ConfigurationError on a
    value of the wrong type or out of range. The parameters are read-only: a component is configured once.
    """
    given, values = _given(node), {}
    for entry in config_type.parameters():
        name = prefix + entry.name
        value = given.get(name, entry.default)
        check(entry._replace(name=name), value)
        if isinstance(entry.default, float):
            value = float(value)  # ROS would refuse a whole number, and ask for 9.0
        node.declare_parameter(name, value, _descriptor(entry), ignore_override=True)
        values[entry.name] = value
    return config_type(**values)


def refuse_unknown(node: Node) -> None:
    """Raise ConfigurationError where the node was given a parameter that it has not declared: a slip of the pen.

    ROS leaves such a parameter out without a word.
    """
    known = node.get_parameters_by_prefix("")
    for name in _given(node):
        if name not in known:
            raise ConfigurationError(f"unknown parameter '{name}'; known are: {', '.join(sorted(known))}")


def _given(node: Node) -> dict[str, Any]:
    """Return the values by name that the command line, files or whoever made the node set."""
    # rclpy (7.1) offers them only through declare_parameter, which knows less than we do of types.
    return {name: override.value for name, override in node._parameter_overrides.items()}  # noqa: SLF001


def _descriptor(entry: Parameter) -> ParameterDescriptor:
    unit = f" [{entry.unit}]" if entry.unit else ""
    descriptor = ParameterDescriptor(description=entry.meaning + unit, read_only=True)
    if math.isfinite(entry.low) and math.isfinite(entry.high):
        if isinstance(entry.default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(entry.low), to_value=float(entry.high))
            ]
        elif type(entry.default) is int:
            descriptor.integer_range = [IntegerRange(from_value=int(entry.low), to_value=int(entry.high), step=1)]
    return descriptor
