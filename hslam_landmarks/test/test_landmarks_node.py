"""The node: every scan is answered, every third looked at, and what is no scan is told and answered."""

import numpy as np
from hslam_msgs.msg import LandmarkObservations, NodeStatus
from rclpy.node import Node
from ros_stage import Stage, Staged
from scanned_walls import box, scan_of
from sensor_msgs.msg import LaserScan

from hslam_landmarks.config import ScanLandmarksConfig
from hslam_landmarks.scan_landmarks import look, lookout_from_mapping
from hslam_landmarks.scan_landmarks_node import ScanLandmarksNode
from hslam_ros.conversions import landmarks_from_msg
from hslam_ros.qos import CYCLE
from hslam_ros.scan_conversion import scan_from_msg, scan_to_msg
from hslam_ros.stamps import stamp_to_msg
from hslam_types.se2 import SE2

STEP_NS = 120_000_000
ROOM = box(-3.0, -2.0, 4.0, 2.5)


class Rest(Node):
    """The scanner, and who listens."""

    def __init__(self) -> None:
        super().__init__("rest")
        self.looks: list[LandmarkObservations] = []
        self.statuses: list[NodeStatus] = []
        self.scan = self.create_publisher(LaserScan, "scan", CYCLE)
        self.create_subscription(LandmarkObservations, "landmarks", self.looks.append, CYCLE)
        self.create_subscription(NodeStatus, "scan_landmarks/status", self.statuses.append, CYCLE)


class Pair(Stage):
    """The node and the rest."""

    def __init__(self, **parameters: object) -> None:
        super().__init__(**parameters)
        self.node, self.rest = self.add(ScanLandmarksNode()), self.add(Rest())

    def say(self, msg: LaserScan, step: int) -> NodeStatus:
        """Publish a scan as that of a step and return the answer."""
        msg.header.stamp = stamp_to_msg(step * STEP_NS)
        answered = len(self.rest.statuses)
        self.rest.scan.publish(msg)
        self.spin_until(lambda: len(self.rest.statuses) > answered)
        return self.rest.statuses[-1]


def test_every_scan_is_answered_and_every_third_looked_at(staged: Staged) -> None:
    pair = staged(Pair, scan_forward_m=0.2)
    msg = scan_to_msg(scan_of(ROOM))
    answers = [pair.say(msg, step) for step in range(1, 8)]
    assert [answer.outputs for answer in answers] == [0, 0, 1, 1, 1, 2, 2]
    assert [answer.header.stamp for answer in answers] == [stamp_to_msg(step * STEP_NS) for step in range(1, 8)]
    pair.spin_until(lambda: len(pair.rest.looks) == 2)
    scan = scan_from_msg(pair.rest.looks[0] and msg, SE2(0.2, 0.0, 0.0))
    heard = landmarks_from_msg(pair.rest.looks[0])
    assert heard.sightings == look(scan, ScanLandmarksConfig()).sightings
    assert len(heard.sightings) == 4
    assert heard.stamp_ns == 3 * STEP_NS


def test_a_scan_that_shows_nothing_is_answered_by_an_empty_look(staged: Staged) -> None:
    pair = staged(Pair, look_every=1)
    scan = scan_of(ROOM)
    scan.ranges[:] = np.inf
    assert pair.say(scan_to_msg(scan), 1).outputs == 1
    pair.spin_until(lambda: len(pair.rest.looks) == 1)
    assert not pair.rest.looks[0].ranges


def test_what_is_no_scan_is_told_and_answered(staged: Staged) -> None:
    pair = staged(Pair, look_every=1)
    msg = scan_to_msg(scan_of(ROOM))
    msg.angle_increment = float("nan")
    answer = pair.say(msg, 1)
    assert (answer.outputs, answer.state) == (0, "blind")
    assert "scan 1" in answer.detail


def test_a_run_in_one_process_looks_as_the_node_does() -> None:
    landmarks, scanner = lookout_from_mapping({"look_every": 2, "scan_left_m": 0.1, "range_max_m": 4.0})
    assert scanner.scanner_in_base == SE2(0.0, 0.1, 0.0)
    scan = scan_of(ROOM)
    looks = [landmarks.hear(scan) for _ in range(4)]
    assert [view is None for view in looks] == [True, False, True, False]
    assert looks[1] == look(scan, ScanLandmarksConfig(range_max_m=4.0))
