"""ROS parameters from configuration dataclasses: declared in one loop, with meaning, unit and range."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from hslam_types.config import Configuration, Parameter, check
from hslam_types.errors import ConfigurationError

C = TypeVar("C", bound=Configuration)


def declare(node: Node, config_type: type[C], prefix: str = "") -> C:
    """Declare every parameter of ``config_type`` on the node and return the configuration it was started with.

    ``prefix`` (such as "sonar.") groups the parameters of one component. Raises ConfigurationError on a
    value of the wrong type or out of range. The parameters are read-only, but for the changeable ones: see `follow`.
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


def follow(node: Node, config_type: type[C], started_with: C, take: Callable[[C], None]) -> None:
    """Hand over the configuration each time a changeable parameter of it is set; what is out of range is refused.

    ``take`` may refuse a configuration by a ConfigurationError, too.
    """
    newest = [started_with]

    def on_set(parameters: list[RosParameter]) -> SetParametersResult:
        changed = {parameter.name: parameter.value for parameter in parameters if parameter.name in names}
        if not changed:
            return SetParametersResult(successful=True)
        try:
            config = dataclasses.replace(newest[0], **changed)
            take(config)
        except ConfigurationError as error:
            return SetParametersResult(successful=False, reason=str(error))
        newest[0] = config
        return SetParametersResult(successful=True)

    names = {entry.name for entry in config_type.parameters() if entry.changeable}
    node.add_on_set_parameters_callback(on_set)


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
    descriptor = ParameterDescriptor(description=entry.meaning + unit, read_only=not entry.changeable)
    if math.isfinite(entry.low) and math.isfinite(entry.high):
        if isinstance(entry.default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(entry.low), to_value=float(entry.high))
            ]
        elif type(entry.default) is int:
            descriptor.integer_range = [IntegerRange(from_value=int(entry.low), to_value=int(entry.high), step=1)]
    return descriptor
