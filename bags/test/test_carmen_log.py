"""Logs of CARMEN are read as they were meant, and a damaged line is named."""

import bz2
import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from hslam_bags.carmen_log import CarmenError, Odometry, Scan, in_order, read_carmen
from hslam_types.se2 import SE2

ODOM = "ODOM 1.0 2.0 0.5 0.1 0.0 0.0 100.25 host 0.25"


def front_laser(beams: int, at: str = "1.1 2.0 0.5 1.0 2.0 0.5") -> str:
    return f"FLASER {beams} {' '.join(str(1.0 + beam) for beam in range(beams))} {at} 100.50 host 0.50"


def messages(path: Path) -> list[Odometry | Scan | str]:
    return [message for message, _ in read_carmen(path)]


def scan_of(tmp_path: Path, line: str) -> Scan:
    (tmp_path / "log").write_text(line + "\n")
    (scan,) = messages(tmp_path / "log")
    assert isinstance(scan, Scan)
    return scan


def test_odometry_scans_and_other_lines_come_in_order(tmp_path: Path) -> None:
    (tmp_path / "log").write_text(f"# a comment\n\nPARAM robot_length 0.7\n{ODOM}\n{front_laser(4)}\n")
    parameter, odometry, scan = messages(tmp_path / "log")
    assert parameter == "PARAM"
    assert odometry == Odometry(100.25, SE2(1.0, 2.0, 0.5))
    assert isinstance(scan, Scan)
    assert (scan.time_s, scan.base_in_odom, scan.scanner_in_odom) == (100.5, (1.0, 2.0, 0.5), (1.1, 2.0, 0.5))
    np.testing.assert_array_equal(scan.ranges, [1.0, 2.0, 3.0, 4.0])


@pytest.mark.parametrize(("beams", "last"), [(180, 89.0), (181, 90.0), (360, 89.5), (361, 90.0)])
def test_a_front_scan_covers_the_half_circle_ahead(tmp_path: Path, beams: int, last: float) -> None:
    scan = scan_of(tmp_path, front_laser(beams))
    assert math.degrees(scan.first_bearing) == pytest.approx(-90.0)
    assert math.degrees(scan.first_bearing + (beams - 1) * scan.bearing_step) == pytest.approx(last)


def test_a_scan_with_its_own_layout_is_read(tmp_path: Path) -> None:
    line = "ROBOTLASER1 0 -2.0 4.0 0.02 30 0.01 0 3 1 2 3 2 7 8 1.1 2 0.5 1 2 0.5 0.1 0 0.3 0.2 0 100.5 host 0.5"
    scan = scan_of(tmp_path, line)
    assert (scan.first_bearing, scan.bearing_step, scan.time_s) == (-2.0, 0.02, 100.5)
    assert (scan.base_in_odom.x, scan.scanner_in_odom.x) == (1.0, 1.1)
    np.testing.assert_array_equal(scan.ranges, [1.0, 2.0, 3.0])


@pytest.mark.parametrize(("ending", "pack"), [(".gz", gzip.compress), (".bz2", bz2.compress)])
def test_packed_logs_are_read_and_cut_ones_named(tmp_path: Path, ending: str, pack: type[bytes]) -> None:
    packed = pack((ODOM + "\n").encode() * 50)
    path = tmp_path / f"log{ending}"
    path.write_bytes(packed)
    assert len(messages(path)) == 50
    path.write_bytes(packed[: len(packed) // 2])
    with pytest.raises(CarmenError, match=f"log{ending}"):
        messages(path)
    path.write_bytes(b"no such packing")
    with pytest.raises(CarmenError, match=f"log{ending}"):
        messages(path)


@pytest.mark.parametrize(
    "line",
    [
        "ODOM 1 2",
        "ODOM 1 2 east 0 0 0 100 host 0",
        "ODOM 1 nan 3 0 0 0 100 host 0",
        "FLASER 3 1 2",
        "FLASER 1 1 0 0 0 0 0 0 100 host 0",
        "FLASER -3 1 2 3 0 0 0 0 0 0 100 host 0",
        "FLASER 2 1 inf 0 0 0 0 0 0 100 host 0",
        "ROBOTLASER1 0 -2.0 4.0 0.02 30 0.01 0 3 1 2 3 99 7 8 1 2 0.5 1 2 0.5 0.1 0 0 0 0 100 host 0",
    ],
)
def test_a_damaged_line_is_named(tmp_path: Path, line: str) -> None:
    (tmp_path / "log").write_text(f"{ODOM}\n{line}\n")
    with pytest.raises(CarmenError, match=rf"line 2: damaged {line.split(maxsplit=1)[0]}"):
        messages(tmp_path / "log")


def test_a_missing_log_is_named(tmp_path: Path) -> None:
    with pytest.raises(CarmenError, match="nowhere"):
        messages(tmp_path / "nowhere")


def test_two_clocks_that_never_step_back_order_a_log(tmp_path: Path) -> None:
    lines = [ODOM.replace("100.25", time_s) for time_s in ("100.6", "100.7")]
    (tmp_path / "log").write_text("\n".join([lines[0], front_laser(4), lines[1]]))
    read = [message for message in messages(tmp_path / "log") if not isinstance(message, str)]
    ordered, steps_back = in_order(read)
    assert ([message.time_s for message in ordered], steps_back) == ([100.5, 100.6, 100.7], 0)
    lines_order = [read[2], read[1], read[0]]
    assert in_order(lines_order) == (lines_order, 1)
