"""Logs of CARMEN, the format of most public laser data sets, as plain values.

Source: the log format of the Carnegie Mellon Robot Navigation Toolkit (`carmen logger`), also described with the data
sets of the Robotics Data Set Repository (Radish). One message a line: a name, its fields, and three fields of time.
"""

import bz2
import gzip
import math
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import IO, cast

import numpy as np

from hslam_bags.errors import BagError
from hslam_types.se2 import SE2, Array


class CarmenError(BagError):
    """A log's line is not what its name promises; the text names file and line."""


@dataclass(frozen=True)
class Odometry:
    """Where the wheels say that the robot is."""

    time_s: float
    base_in_odom: SE2


@dataclass(frozen=True, eq=False)
class Scan:
    """The ranges of a planar scanner and where odometry has it."""

    time_s: float
    base_in_odom: SE2
    scanner_in_odom: SE2
    first_bearing: float
    """Direction (rad) of the first beam in the scanner's frame, each next one ``bearing_step`` on."""
    bearing_step: float
    ranges: Array
    """Metres."""


def in_order(messages: list[Odometry | Scan]) -> tuple[list[Odometry | Scan], int]:
    """Return a log's messages in the order they were said, and how often its clock steps back.

    Programs of their own write odometry and scans, each later than it was said by another delay: where the clock of
    either never steps back, time orders them. Where it does, times are worth less than the order of the lines.
    """
    kinds = [[message.time_s for message in messages if isinstance(message, kind)] for kind in (Odometry, Scan)]
    steps_back = sum(after < before for times in kinds for before, after in pairwise(times))
    return (messages, steps_back) if steps_back else (sorted(messages, key=lambda message: message.time_s), 0)


def read_carmen(path: Path) -> Iterator[tuple[Odometry | Scan | str, int]]:
    """Yield each line's message, or the name of one that holds none, with the bytes read so far (packed ones).

    Raises CarmenError where the file cannot be read or a line is damaged.
    """
    try:
        with path.open("rb") as raw:
            for number, line in enumerate(_opened(raw, path.suffix), 1):
                words = line.decode("ascii", "replace").split()
                if not words or words[0].startswith("#"):
                    continue
                try:
                    message = _PARSERS.get(words[0], _unread)(words)
                except (ValueError, IndexError) as error:
                    raise CarmenError(path, f"line {number}", f"damaged {words[0]} ({error})") from error
                yield message, raw.tell()
    except (OSError, EOFError, zlib.error) as error:
        raise CarmenError(path, "", str(error)) from error


def _opened(raw: IO[bytes], ending: str) -> IO[bytes]:
    """Return a log's plain bytes, unpacked as its name's ending says."""
    if ending == ".bz2":
        return cast(IO[bytes], bz2.BZ2File(raw))
    return cast(IO[bytes], gzip.GzipFile(fileobj=raw)) if ending == ".gz" else raw


def _unread(words: list[str]) -> str:
    return words[0]


def _odometry(words: list[str]) -> Odometry:
    """Read `ODOM x y theta tv rv accel time host logger_time`."""
    return Odometry(_number(words[7]), _pose(words[1:4]))


def _front_laser(words: list[str]) -> Scan:
    """Read `FLASER n r1..rn x y theta odom_x odom_y odom_theta time host logger_time`, over 180 degrees ahead."""
    count = int(words[1])
    ranges = _numbers(words[2 : 2 + count], count)
    rest = words[2 + count :]
    # 180 or 360 beams leave out the last of the half circle, 181 or 361 have both ends.
    step = math.pi / (count - 1 if count % 2 else count)
    return Scan(_number(rest[6]), _pose(rest[3:6]), _pose(rest[0:3]), -0.5 * math.pi, step, ranges)


def _robot_laser(words: list[str]) -> Scan:
    """Read a scan with the scanner's own layout.

    `ROBOTLASER1 type start fov step max accuracy remission n r1..rn m e1..em laser-pose robot-pose tv rv
    forward-safety side-safety turn-axis time host logger_time`.
    """
    first, step, count = _number(words[2]), _number(words[4]), int(words[8])
    ranges = _numbers(words[9 : 9 + count], count)
    rest = words[10 + count + int(words[9 + count]) :]
    return Scan(_number(rest[11]), _pose(rest[3:6]), _pose(rest[0:3]), first, step, ranges)


def _pose(words: list[str]) -> SE2:
    x, y, theta = (_number(word) for word in words)
    return SE2(x, y, theta)


def _number(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(f"{word} is no number")
    return value


def _numbers(words: list[str], count: int) -> Array:
    if len(words) != count or count < 2:
        raise ValueError(f"{len(words)} of {count} ranges")
    values: Array = np.array(words, dtype=np.float64)
    if not np.isfinite(values).all():
        raise ValueError("a range is no number")
    return values


_PARSERS: dict[str, Callable[[list[str]], Odometry | Scan | str]] = {
    "ODOM": _odometry,
    "FLASER": _front_laser,
    "ROBOTLASER1": _robot_laser,
}
