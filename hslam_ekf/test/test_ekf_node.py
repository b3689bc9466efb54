"""The node against the plain loop: bit for bit, in whatever order DDS delivers; what it shows; free running."""

import math
import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from hslam_msgs.msg import EdgeMap, FrameLink, GvgEvent, LandmarkObservations, NodeStatus
from nav_msgs.msg import Odometry
from rclpy.node import Node
from ros_stage import Stage, Staged
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from hslam_ekf.ekf_node import EkfNode
from hslam_ekf.server import EkfServer
from hslam_ekf.synthetic_drive import DriveErrors, DriveStep, corridor_landmarks, drive
from hslam_ros import conversions
from hslam_ros.qos import CYCLE, EVENTS, LATCHED
from hslam_ros.stamps import stamp_from_msg
from hslam_types.se2 import SE2
from hslam_types.sensing import PlanarCovariance

PATH = np.array([[0.0, 0.0], [6.0, 0.0]])
LAST_SEQUENCE = 2


def short_drive() -> list[DriveStep]:
    """Return a drive along six metres."""
    rng = np.random.default_rng(5)
    return drive(PATH, corridor_landmarks(PATH, rng), DriveErrors(), rng)


class Rest(Node):
    """The rest of the suite: says what the base and gvg say, in any order within a cycle, and keeps what ekf says."""

    def __init__(self) -> None:
        super().__init__("rest")
        self.edge_maps: list[EdgeMap] = []
        self.links: list[FrameLink] = []
        self.statuses: list[NodeStatus] = []
        self.poses: list[PoseWithCovarianceStamped] = []
        self.transforms: list[TFMessage] = []
        self.pictures: list[MarkerArray] = []
        self._odom = self.create_publisher(Odometry, "odom", CYCLE)
        self._landmarks = self.create_publisher(LandmarkObservations, "landmarks", CYCLE)
        self._events = self.create_publisher(GvgEvent, "gvg/events", EVENTS)
        self._gvg = self.create_publisher(NodeStatus, "gvg/status", CYCLE)
        self._sim = self.create_publisher(NodeStatus, "sim/status", CYCLE)
        self.create_subscription(EdgeMap, "ekf/edge_maps", self.edge_maps.append, EVENTS)
        self.create_subscription(FrameLink, "ekf/frame_links", self.links.append, EVENTS)
        self.create_subscription(NodeStatus, "ekf/status", self.statuses.append, CYCLE)
        self.create_subscription(PoseWithCovarianceStamped, "ekf/pose", self.poses.append, CYCLE)
        self.create_subscription(TFMessage, "/tf", self.transforms.append, 100)
        self.create_subscription(MarkerArray, "ekf/map", self.pictures.append, LATCHED)
        self._said = {"sim": 0, "gvg": 0}

    def say(self, step: DriveStep, shuffle: random.Random | None = None) -> None:
        """Publish one cycle."""
        stamp_ns = step.odom.stamp_ns
        words: list[Callable[[], None]] = [lambda: self._odom.publish(conversions.odometry_to_msg(step.odom))]
        view = step.view
        if view is not None:
            self._said["sim"] += 1
            words.append(lambda: self._landmarks.publish(conversions.landmarks_to_msg(view)))
        self._said["gvg"] += len(step.events)
        words += [lambda e=e: self._events.publish(conversions.event_to_msg(e)) for e in step.events]  # type: ignore[misc]
        about = conversions.header(stamp_ns, "")
        for name, topic in (("sim", self._sim), ("gvg", self._gvg)):
            status = NodeStatus(header=about, node=name, outputs=self._said[name])
            words.append(lambda topic=topic, status=status: topic.publish(status))  # type: ignore[misc]
        if shuffle is not None:
            shuffle.shuffle(words)
        for word in words:
            word()


class Pair(Stage):
    """The node and the rest of the suite."""

    def __init__(self, **parameters: object) -> None:
        super().__init__(**parameters)
        self.ekf, self.rest = self.add(EkfNode()), self.add(Rest())

    def lock_step(self, steps: list[DriveStep], shuffle: random.Random | None = None) -> None:
        """Say each cycle and wait until the node has answered it."""
        for step in steps:
            answered = len(self.rest.statuses)
            self.rest.say(step, shuffle)
            self.spin_until(lambda answered=answered: len(self.rest.statuses) > answered)  # type: ignore[misc]


def at(msg: Any) -> int:
    """Return the stamp (ns) of a message with a header."""
    return stamp_from_msg(msg.header.stamp)


def test_lock_step_gives_the_bits_of_the_plain_loop(staged: Staged) -> None:
    pair = staged(Pair)
    rest = pair.rest
    steps = short_drive()
    last = steps[-1].odom.stamp_ns
    pair.lock_step(steps, random.Random(1))
    pair.spin_until(lambda: bool(rest.edge_maps and rest.links and rest.poses) and at(rest.poses[-1]) == last)
    plain = EkfServer()
    passed = [conversions.odometry_from_msg(conversions.odometry_to_msg(step.odom)) for step in steps]
    outs = [plain.step(odom, step.view, step.events) for odom, step in zip(passed, steps, strict=True)]
    (expected,) = [m for out in outs for m in out.edge_maps]
    (link,) = [m for out in outs for m in out.links]
    got = conversions.edge_map_from_msg(rest.edge_maps[0])
    assert np.array_equal(got.landmarks, expected.landmarks)
    assert np.array_equal(got.covariance, expected.covariance)
    assert got.robot_at_arrival == expected.robot_at_arrival
    assert conversions.link_from_msg(rest.links[0]).departure_in_edge == link.departure_in_edge
    assert [at(status) for status in rest.statuses] == [step.odom.stamp_ns for step in steps]
    assert (rest.statuses[-1].outputs, rest.statuses[-1].state) == (2, "mapping")
    done = [0]
    for step in steps:
        done.append(step.events[-1].sequence + 1 if step.events else done[-1])
    assert [status.next_event for status in rest.statuses] == done[1:]
    assert done[-1] == LAST_SEQUENCE + 1
    poses = {step.odom.stamp_ns: out.base_in_edge for step, out in zip(steps, outs, strict=True)}
    assert all(msg.pose.pose.position.x == poses[at(msg)].x for msg in rest.poses)  # type: ignore[union-attr]


def test_it_shows_transform_and_map(staged: Staged) -> None:
    pair = staged(Pair, map_every_s=0.0)
    rest = pair.rest
    steps = short_drive()[:40]
    pair.lock_step(steps)
    last = steps[-1].odom.stamp_ns
    pair.spin_until(lambda: bool(rest.transforms and rest.pictures) and at(rest.poses[-1]) == last)
    transform = rest.transforms[-1].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("edge_0", "odom")
    stamp_ns = at(transform)
    pose = next(msg for msg in rest.poses if at(msg) == stamp_ns).pose.pose.position
    odom_in_edge = SE2(
        transform.transform.translation.x,
        transform.transform.translation.y,
        conversions.yaw_from_quaternion(transform.transform.rotation),
    )
    again = odom_in_edge @ next(step.odom.base_in_odom for step in steps if step.odom.stamp_ns == stamp_ns)
    assert (again.x, again.y) == pytest.approx((pose.x, pose.y), abs=1e-9)
    landmarks, ellipses = rest.pictures[-1].markers
    assert len(landmarks.points) > 0
    assert len(ellipses.points) == 16 * len(landmarks.points)


def test_running_freely_a_missing_status_holds_nothing_up(staged: Staged) -> None:
    pair = staged(Pair, lockstep="false")
    rest = pair.rest
    pair.spin_until(lambda: pair.ekf.count_publishers("odom") > 0 and rest.count_subscribers("odom") > 0)
    for i, step in enumerate(short_drive()[:20]):
        rest._odom.publish(conversions.odometry_to_msg(step.odom))
        # Three cycles later the hold-back of 0.3 s is over.
        pair.spin_until(lambda i=i: len(rest.statuses) >= i - 2)  # type: ignore[misc]
    assert {status.state for status in rest.statuses} == {"waiting"}


def test_reset_forgets_the_traversal(staged: Staged) -> None:
    pair = staged(Pair)
    rest = pair.rest
    steps = short_drive()[:4]
    pair.lock_step(steps[:3])
    assert rest.statuses[-1].state == "mapping"
    assert pair.call(rest, Trigger, "ekf/reset", Trigger.Request()).success
    pair.lock_step(steps[3:])
    assert rest.statuses[-1].state == "waiting"


def test_what_is_refused_is_answered_and_told_and_the_traversal_goes_on(staged: Staged) -> None:
    pair = staged(Pair)
    rest = pair.rest
    steps = short_drive()[:30]
    pair.lock_step(steps[:20])
    before = pair.ekf._server.traversal
    lost, blind = steps[20], next(i for i in range(21, 30) if steps[i].view is not None)
    pair.lock_step([replace(lost, odom=replace(lost.odom, base_in_odom=SE2(math.nan, 0.0, 0.0)))])
    assert rest.statuses[-1].state == "blind"
    assert rest.statuses[-1].detail.startswith("refused messages: odom 1; odometry is weighed by")
    pair.lock_step(steps[21:blind])
    view = steps[blind].view
    assert view is not None
    zero = replace(view, sightings=tuple(s._replace(range_std_m=0.0) for s in view.sightings))
    pair.lock_step([replace(steps[blind], view=zero)])
    assert rest.statuses[-1].state == "mapping"
    assert rest.statuses[-1].detail.startswith("refused messages: landmarks 1, odom 1; ")
    assert pair.ekf._server.traversal is before
    pair.lock_step(steps[blind + 1 :])
    assert [at(status) for status in rest.statuses] == [step.odom.stamp_ns for step in steps]
    assert before is not None
    pose, covariance = before.filter.pose()
    assert math.hypot(pose.x - steps[-1].base_in_map.x, pose.y - steps[-1].base_in_map.y) < 0.5
    assert np.isfinite(covariance).all()


def test_by_which_noise_odometry_is_weighed_is_told_once(staged: Staged) -> None:
    pair = staged(Pair)
    steps, said = short_drive()[:12], list[str]()
    pair.ekf.get_logger().warning = said.append
    pair.lock_step(steps[:6])
    assert said == ["odometry is weighed by the configured constants (it gives no covariances)"]
    assert pair.rest.statuses[-1].detail == said[0]
    fine = PlanarCovariance(1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4)
    pair.lock_step([replace(step, odom=replace(step.odom, twist_covariance=fine)) for step in steps[6:9]])
    assert said[1:] == ["odometry is weighed by its twist covariance"]
    bad = fine._replace(xx=-1.0)
    pair.lock_step([replace(step, odom=replace(step.odom, twist_covariance=bad)) for step in steps[9:]])
    assert len(said) == 2
    assert "(its twist covariance has a variance forward of -1" in pair.rest.statuses[-1].detail


@pytest.mark.parametrize("broken", ["time", "gvg", "pose"])
def test_what_begins_anew_loses_the_traversal_and_the_next_one_is_mapped(staged: Staged, broken: str) -> None:
    """A bag that loops, gvg started again, a base that was carried away."""
    pair = staged(Pair)
    steps = short_drive()
    half = len(steps) // 2
    pair.lock_step(steps[:half])
    assert pair.rest.statuses[-1].state == "mapping"
    later = steps[half]
    if broken == "time":
        for source in pair.rest._said:
            pair.rest._said[source] = 0
    elif broken == "gvg":
        pair.rest._said["gvg"] = 0
        pair.lock_step([later])
    else:
        x, y, theta = later.odom.base_in_odom
        pair.lock_step([replace(later, odom=replace(later.odom, base_in_odom=SE2(x + 5.0, y, theta)))])
    if broken != "time":
        assert pair.rest.statuses[-1].state == "waiting"
        return
    pair.rest.poses.clear()
    pair.lock_step(steps)
    pair.spin_until(lambda: len(pair.rest.edge_maps) == 1)
    assert pair.rest.poses
    assert pair.rest.edge_maps[0].terminal_x == pytest.approx(6.0, abs=0.1)
