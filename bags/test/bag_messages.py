"""Messages serialised by hand, and bags of them."""

import struct
from pathlib import Path

from hslam_bags.definitions import DefinitionSource
from hslam_bags.recorder import Recorder, RecorderConfig

STRING = "std_msgs/msg/String"
STAMPED = "geometry_msgs/msg/Vector3Stamped"


def string_cdr(text: str) -> bytes:
    """Serialise a std_msgs/String by hand: encapsulation, length with the final zero, bytes."""
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + struct.pack("<I", len(data)) + data


def stamped_cdr(stamp_ns: int, x: float) -> bytes:
    """Serialise a Vector3Stamped with frame "map", padded to the doubles' alignment."""
    head = struct.pack("<iII", stamp_ns // 10**9, stamp_ns % 10**9, 4) + b"map\0"
    return b"\0\1\0\0" + head + struct.pack("<ddd", x, 0.0, 0.0)


def record_strings(bag: Path, definitions: DefinitionSource, count: int, config: RecorderConfig) -> list[bytes]:
    """Record ``count`` strings a millisecond apart and return them."""
    raws = [string_cdr(f"message {index}") for index in range(count)]
    with Recorder(bag, config, definitions=definitions) as recorder:
        for index, raw in enumerate(raws):
            recorder.write("/chatter", STRING, raw, index * 10**6)
    return raws
