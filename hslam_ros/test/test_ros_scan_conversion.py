"""A scan through the bytes of its message and back."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import LaserScan

from hslam_ros.scan_conversion import scan_from_msg, scan_to_msg
from hslam_types.errors import MessageError
from hslam_types.se2 import SE2
from hslam_types.sensing import RangeScan

MOUNTING = SE2(0.1, -0.02, 0.5)
single = st.floats(width=32, allow_nan=True, allow_infinity=True)
angle = st.floats(-3.0, 3.0, width=32)


@given(st.lists(single, max_size=40), st.integers(0, 2**31 * 10**9 - 1), angle, st.floats(2.0**-10, 0.125, width=32))
def test_a_scan_of_any_length_survives_its_message(
    values: list[float], stamp_ns: int, first: float, step: float
) -> None:
    scan = RangeScan(stamp_ns, MOUNTING, first, step, 0.125, 8.0, np.array(values, dtype=np.float64))
    msg = deserialize_message(serialize_message(scan_to_msg(scan)), LaserScan)
    back = scan_from_msg(msg, MOUNTING)
    assert np.array_equal(back.ranges, scan.ranges, equal_nan=True)
    same = ("stamp_ns", "sensor_in_base", "first_bearing", "bearing_step", "range_min_m", "range_max_m")
    assert all(getattr(back, name) == getattr(scan, name) for name in same)
    assert np.allclose(back.bearings, scan.bearings)


def test_a_scan_taken_clockwise_is_turned_about() -> None:
    msg = LaserScan(angle_min=1.0, angle_max=-1.0, angle_increment=-1.0, range_max=9.0, ranges=[1.0, 2.0, 3.0])
    scan = scan_from_msg(msg, MOUNTING)
    assert scan.ranges.tolist() == [3.0, 2.0, 1.0]
    assert scan.bearings.tolist() == [-1.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("angle_min", math.nan),
        ("angle_increment", math.inf),
        ("angle_increment", 0.0),
        ("angle_increment", 4.0),
        ("range_min", -1.0),
        ("range_max", math.nan),
        ("range_max", 0.0),
    ],
)
def test_a_scan_that_cannot_be_is_refused_by_its_field(field: str, value: float) -> None:
    msg = LaserScan(angle_min=0.0, angle_increment=0.1, range_min=0.1, range_max=9.0, ranges=[1.0, 2.0, 3.0])
    setattr(msg, field, value)
    with pytest.raises(MessageError, match=field):
        scan_from_msg(msg, MOUNTING)


def test_a_message_is_the_same_before_it_is_sent_and_after() -> None:
    scan = RangeScan(0, MOUNTING, -math.pi, math.tau / 360, 0.12, 8.1, np.full(360, 1.1))
    msg = scan_to_msg(scan)
    assert msg == deserialize_message(serialize_message(msg), LaserScan)
