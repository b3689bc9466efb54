"""The landmarks of a lidar as a node: hears scans, says what landmarks are in them."""

from dataclasses import dataclass
from functools import partial

from hslam_msgs.msg import LandmarkObservations, NodeStatus
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

from hslam_landmarks.config import ScanLandmarksConfig, ScannerConfig
from hslam_landmarks.scan_landmarks import ScanLandmarks
from hslam_ros import conversions
from hslam_ros.door import Door
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE, sensor_subscription
from hslam_ros.scan_conversion import scan_from_msg
from hslam_ros.spin import run
from hslam_types.config import Configuration, parameter
from hslam_types.sensing import RangeScan


@dataclass(frozen=True)
class LinkConfig(Configuration):
    """How the node is joined to the others."""

    lockstep: bool = parameter(True, "hear every scan, however late; otherwise the newest")


class ScanLandmarksNode(Node):
    """Answers every scan by a status, and every so manieth by a look before it."""

    def __init__(self) -> None:
        """Declare parameters and topics; raises ConfigurationError on a bad parameter."""
        super().__init__("scan_landmarks")
        link, scanner = declare(self, LinkConfig), declare(self, ScannerConfig)
        self._landmarks = ScanLandmarks(declare(self, ScanLandmarksConfig))
        self._looks = 0
        self._look = self.create_publisher(LandmarkObservations, "landmarks", CYCLE)
        # Looks come every few cycles: the count tells listeners whether this cycle's is still on its way.
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)
        self._door = Door(self)
        convert = partial(scan_from_msg, sensor_in_base=scanner.scanner_in_base)
        sensors = sensor_subscription(link.lockstep)
        self._door.hear(LaserScan, "scan", convert, self._on_scan, sensors, self._on_refused)

    def _on_scan(self, scan: RangeScan) -> None:
        look = self._landmarks.hear(scan)
        if look is not None:
            self._looks += 1
            self._look.publish(conversions.landmarks_to_msg(look))
        self._answer(scan.stamp_ns, "looking")

    def _on_refused(self, stamp_ns: int | None) -> None:
        if stamp_ns is not None:
            self._answer(stamp_ns, "blind")

    def _answer(self, stamp_ns: int, state: str) -> None:
        status = NodeStatus(header=conversions.header(stamp_ns, ""), node=self.get_name(), outputs=self._looks)
        status.state, status.detail = state, self._door.report()
        self._status.publish(status)


def main() -> None:
    """Run the node until a signal."""
    run(ScanLandmarksNode)
