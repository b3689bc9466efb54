"""Readings on the driver's clock made into values stamped with ROS time."""

from collections.abc import Sequence

from hslam_types.sensing import SCOUT_RING, OdometrySample, SonarPing, SonarSweep
from scout_driver.driver import Reading

NS_PER_S = 1e9
NS_PER_MS = 1_000_000


class ReadingStamps:
    """Knows how the driver's clock, or the base's, maps to ROS time."""

    def __init__(self, *, board: bool) -> None:
        """``board``: ROS time is the base's own clock, as with an emulator; otherwise see `anchor`."""
        self._board = board
        self._ros_ns, self._driver_s = 0, 0.0

    def anchor(self, ros_ns: int, driver_s: float) -> None:
        """Note that ROS time and the driver's clock show this at one moment."""
        self._ros_ns, self._driver_s = ros_ns, driver_s

    def stamp_ns(self, reading: Reading) -> int:
        """Return when a reading was measured."""
        if self._board and reading.state.board_ms is not None:
            return reading.state.board_ms * NS_PER_MS
        return self._ros_ns + round((reading.stamp_s - self._driver_s) * NS_PER_S)

    def odometry(self, reading: Reading) -> OdometrySample:
        """Return a reading's odometry."""
        return OdometrySample(self.stamp_ns(reading), reading.base_in_odom, reading.velocity)

    def sweep(self, reading: Reading, pings: Sequence[tuple[float, SonarPing]]) -> SonarSweep:
        """Return pings as a sweep that ends with a reading; each ping keeps its own moment of firing."""
        end_ns = self.stamp_ns(reading)
        stamped = (
            ping._replace(stamp_ns=end_ns - round((reading.stamp_s - fired_s) * NS_PER_S)) for fired_s, ping in pings
        )
        return SonarSweep(end_ns, SCOUT_RING, tuple(stamped))
