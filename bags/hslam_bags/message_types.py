"""Message classes by the names bags use."""

from importlib import import_module
from typing import Any


def message_class(type_name: str) -> Any:
    """Return the class of a type such as ``nav_msgs/msg/Odometry``; LookupError says what is not installed."""
    parts = type_name.split("/")
    if len(parts) != 3:
        raise LookupError(f"'{type_name}' is no message type; one looks like nav_msgs/msg/Odometry")
    package, kind, name = parts
    try:
        return getattr(import_module(f"{package}.{kind}"), name)
    except (ImportError, AttributeError) as error:
        raise LookupError(f"{type_name} is not installed here ({error}); is its package built and sourced?") from error
