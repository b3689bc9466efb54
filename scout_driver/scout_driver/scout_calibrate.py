"""Guided calibration on the command line: `ros2 run scout_driver scout_calibrate --port /dev/ttyUSB0`."""

import argparse
import math
import sys
import time

from hslam_types.errors import HslamError
from scout_driver.calibration import Calibrator, calibrate
from scout_driver.clock import WallClock
from scout_driver.config import DriverConfig
from scout_driver.driver import ScoutDriver
from scout_driver.transport import open_transport


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def _ask(question: str) -> float:
    _say(question)
    while True:
        try:
            return float(sys.stdin.readline().strip().replace(",", "."))
        except ValueError:
            _say("a number, please:")


def _guide(options: argparse.Namespace) -> None:
    """Lead through both legs and say what to set."""
    config, clock = DriverConfig(port=options.port, swap_wheels=options.swap_wheels), WallClock()
    driver = ScoutDriver(config, clock, lambda: open_transport(config.port, config.baud))
    try:
        _say(f"The base will drive {options.distance:g} m straight on, then turn {options.turns} times to the left.")
        _say("Clear the floor, keep a hand on the emergency stop, mark where its centre stands, and press Enter.")
        sys.stdin.readline()
        driver.enable()
        calibrator = Calibrator(driver, lambda _: time.sleep(config.cycle_s / 4.0))
        line = calibrator.line(options.distance)
        measured = _ask(f"It reports {line.distance_m:.3f} m. How far has its centre moved? (m)")
        _say("Mark where it faces, and press Enter.")
        sys.stdin.readline()
        turns = calibrator.turns(options.turns)
        reported = math.degrees(math.remainder(turns.turned_rad, 2.0 * math.pi))
        beyond = _ask(
            f"By its own heading it faces {reported:+.1f} deg from the mark. "
            "How far to the left of the mark does it face? (deg, negative: to the right)"
        )
        found = calibrate(line, measured, turns, math.radians(beyond))
    finally:
        driver.close()
    _say("Set in the parameters of scout_node:")
    _say(f"  distance_scale: {found.distance_scale:.4f}")
    _say(f"  rotation_scale: {found.rotation_scale:.4f}")
    _say(f"  wheel_base_m: {found.wheel_base_m:.4f}")


def main() -> None:
    """Run the guide; exits 1 with one line if it cannot be finished."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", default=DriverConfig().port, help="serial device, or tcp://host:port")
    parser.add_argument("--distance", type=float, default=2.0, help="length of the straight leg (m)")
    parser.add_argument("--turns", type=int, default=5, help="turns on the spot")
    parser.add_argument("--swap-wheels", action="store_true", help="the left wheel comes first on the wire")
    try:
        _guide(parser.parse_args())
    except KeyboardInterrupt:
        sys.exit(130)
    except HslamError as error:
        sys.stderr.write(f"scout_calibrate: {error}\n")
        sys.exit(1)


if __name__ == "__main__":
    main()
