"""A CARMEN log becomes a bag of standard messages, as a robot's drivers would have said them."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from hslam_bags.carmen_log import Odometry, Scan, in_order, read_carmen
from hslam_bags.recorder import Recorder
from hslam_bringup.errors import RunError
from hslam_bringup.run_record import RunRecord
from hslam_ros.conversions import odometry_to_msg
from hslam_ros.scan_conversion import FRAME, scan_to_msg
from hslam_ros.stamps import NS_PER_S
from hslam_ros.transforms import transform_to_msg
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample, RangeScan

_APART_NS = 1_000_000
"""Least time between two messages, where the log's clock stands still or steps back: the file's order holds."""
_RANGE_MIN_M = 0.02
_SHOW_EVERY = 500


@dataclass(frozen=True)
class Imported:
    """What a log held."""

    scans: int
    odometry: int
    """Messages of odometry, those that came with scans included."""
    seconds: float
    driven_m: float
    """By odometry."""
    clock_steps_back: int
    left_out: dict[str, int]
    """Lines by name that hold nothing a robot without a gripper would say."""
    scanner_in_base: tuple[float, float, float]
    """Forward, left (m) and yaw (rad): the parameters `scan_forward_m`, `scan_left_m` and `scan_yaw`."""

    @property
    def fields(self) -> dict[str, object]:
        """The fields of the report."""
        return asdict(self)


def import_carmen(log: Path, out: Path, range_max_m: float, show: Callable[[int], None]) -> Imported:
    """Write a log's odometry, scans and transforms to a new bag; ``show(bytes read)`` is called now and then.

    Readings from ``range_max_m`` on are "nothing answered". Raises CarmenError where a line is damaged, BagError where
    the bag cannot be written, RunError where the log holds no scan.
    """
    messages: list[Odometry | Scan] = []
    left_out: Counter[str] = Counter()
    for count, (message, read) in enumerate(read_carmen(log)):
        if isinstance(message, str):
            left_out[message] += 1
        else:
            messages.append(message)
        if count % _SHOW_EVERY == 0:
            show(read)
    if not any(isinstance(message, Scan) for message in messages):
        raise RunError(f"{log} holds no scan (FLASER or ROBOTLASER1): is it a CARMEN log?")
    messages, steps_back = in_order(messages)
    with Recorder(out) as recorder:
        bag = _Bag(RunRecord(recorder), range_max_m)
        for message in messages:
            bag.put(message)
    return bag.summary(steps_back, dict(left_out))


class _Bag:
    """Says a log's messages in ROS's words, and counts."""

    def __init__(self, record: RunRecord, range_max_m: float) -> None:
        self._record, self._range_max_m = record, range_max_m
        self._stamps_ns: list[int] = []
        self._scans = 0
        self._base: SE2 | None = None
        self._scanner = SE2(0.0, 0.0, 0.0)
        self._driven_m = 0.0

    def put(self, message: Odometry | Scan) -> None:
        """Record a message under a time that is later than the last one's."""
        stamp_ns = round(message.time_s * NS_PER_S)
        if self._stamps_ns:
            stamp_ns = max(stamp_ns, self._stamps_ns[-1] + _APART_NS)
        self._stamps_ns.append(stamp_ns)
        base = message.base_in_odom
        self._driven_m += 0.0 if self._base is None else math.dist(self._base[:2], base[:2])
        self._base = base
        self._record.put("/odom", odometry_to_msg(OdometrySample(stamp_ns, base)), stamp_ns)
        self._record.put("/tf", transform_to_msg(stamp_ns, "odom", "base_link", base), stamp_ns)
        if isinstance(message, Scan):
            self._put_scan(message, stamp_ns)

    def _put_scan(self, scan: Scan, stamp_ns: int) -> None:
        if not self._scans:
            self._scanner = scan.base_in_odom.to(scan.scanner_in_odom)
            self._record.put("/tf_static", transform_to_msg(stamp_ns, "base_link", FRAME, self._scanner), stamp_ns)
        self._scans += 1
        ranges = np.where(scan.ranges >= self._range_max_m, np.inf, scan.ranges)
        heard = RangeScan(
            stamp_ns, self._scanner, scan.first_bearing, scan.bearing_step, _RANGE_MIN_M, self._range_max_m, ranges
        )
        self._record.put("/scan", scan_to_msg(heard), stamp_ns)

    def summary(self, clock_steps_back: int, left_out: dict[str, int]) -> Imported:
        """Return what there was."""
        return Imported(
            self._scans,
            len(self._stamps_ns),
            (self._stamps_ns[-1] - self._stamps_ns[0]) / NS_PER_S,
            self._driven_m,
            clock_steps_back,
            left_out,
            (self._scanner.x, self._scanner.y, self._scanner.theta),
        )
