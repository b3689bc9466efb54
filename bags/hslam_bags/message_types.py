"""Message classes by the names bags use."""

import re
from importlib import import_module
from typing import Any

_NAME = re.compile(r"([A-Za-z]\w*)/(msg|srv|action)/([A-Za-z]\w*)", re.ASCII)


def message_class(type_name: str) -> Any:
    """Return the class of a type such as ``nav_msgs/msg/Odometry``; LookupError says what is not installed."""
    found = _NAME.fullmatch(type_name)
    if found is None:
        raise LookupError(f"'{type_name}' is no message type; one looks like nav_msgs/msg/Odometry")
    package, kind, name = found.groups()
    try:
        return getattr(import_module(f"{package}.{kind}"), name)
    except (ImportError, AttributeError) as error:
        raise LookupError(f"{type_name} is not installed here ({error}); is its package built and sourced?") from error
