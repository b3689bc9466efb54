"""ROS time as integer nanoseconds; floating seconds would lose exactness."""

from builtin_interfaces.msg import Time

NS_PER_S = 1_000_000_000
FOREVER_NS = (2**31 - 1) * NS_PER_S
"""The stamp of a status that answers every cycle to come: the latest that a message can hold in whole seconds."""


def stamp_to_msg(stamp_ns: int) -> Time:
    """Return ``stamp_ns`` (ns since the epoch of ROS time) as a message."""
    seconds, nanoseconds = divmod(stamp_ns, NS_PER_S)
    return Time(sec=seconds, nanosec=nanoseconds)


def stamp_from_msg(stamp: Time) -> int:
    """Return a message's stamp in nanoseconds."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)
