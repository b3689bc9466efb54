"""ROS parameters from configuration dataclasses: declared in one loop, with meaning, unit and range."""

import math
from typing import TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterUninitializedException,
)
from rclpy.node import Node

from hslam_types.config import Configuration, Parameter
from hslam_types.errors import ConfigurationError

C = TypeVar("C", bound=Configuration)


def declare(node: Node, config_type: type[C], prefix: str = "") -> C:
    """Declare every parameter of ``config_type`` on the node and return the configuration it was started with.

    ``prefix`` (such as "sonar.") groups the parameters of one component. Raises ConfigurationError on a
    value of the wrong type or out of range. The parameters are read-only: a component is configured once.
    """
    values = {}
    for entry in config_type.parameters():
        name = prefix + entry.name
        try:
            values[entry.name] = node.declare_parameter(name, entry.default, _descriptor(entry)).value
        except (
            InvalidParameterTypeException,
            InvalidParameterValueException,
            ParameterUninitializedException,
        ) as error:
            raise ConfigurationError(f"parameter '{name}': {error} ({entry.meaning})") from error
    return config_type(**values)


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
