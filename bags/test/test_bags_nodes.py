"""Recording and replaying over DDS: nothing lost, nothing changed, nobody outrun."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from bag_messages import STRING, string_cdr
from geometry_msgs.msg import Vector3Stamped
from hslam_msgs.msg import NodeStatus
from rclpy.node import Node
from rclpy.serialization import serialize_message
from ros_stage import Stage, Staged
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from hslam_bags.bag import Bag
from hslam_bags.errors import BagError
from hslam_bags.qos import LATCHED as LATCHED_OFFER
from hslam_bags.qos import OfferedQos
from hslam_bags.record_node import RecordNode
from hslam_bags.recorder import Recorder
from hslam_bags.replay_node import ReplayNode
from hslam_ros.qos import CYCLE, LATCHED, SENSOR
from hslam_ros.stamps import stamp_from_msg, stamp_to_msg
from hslam_types.errors import ConfigurationError, HslamError

STEP_NS = 120_000_000


def vector(stamp_ns: int, x: float) -> Vector3Stamped:
    msg = Vector3Stamped()
    msg.header.stamp = stamp_to_msg(stamp_ns)
    msg.vector.x = x
    return msg


def publish_run(source: Node, steps: int) -> dict[str, list[bytes]]:
    """Publish a clock and two sensors, one reliable and one not; return what was published."""
    clock = source.create_publisher(Clock, "/clock", CYCLE)
    reliable = source.create_publisher(Vector3Stamped, "odom", CYCLE)
    unreliable = source.create_publisher(Vector3Stamped, "camera", SENSOR)
    said: dict[str, list[bytes]] = {"/odom": [], "/camera": []}
    for step in range(1, steps + 1):
        clock.publish(Clock(clock=stamp_to_msg(step * STEP_NS)))
        for topic, publisher in (("/odom", reliable), ("/camera", unreliable)):
            said[topic].append(serialize_message(vector(step * STEP_NS, float(step))))
            publisher.publish(said[topic][-1])
    return said


def test_records_everything_latched_and_late(staged: Staged, bag: Path) -> None:
    stage = staged(Stage, path=bag, require="odom,camera", find_every_s=0.02)
    source = stage.add(Node("source"))
    latched = source.create_publisher(String, "map", LATCHED)
    latched.publish(String(data="the floor"))  # before anyone records
    answers: list[NodeStatus] = []
    source.create_subscription(NodeStatus, "record/status", answers.append, LATCHED)
    first = publish_run(source, 0)
    assert first == {"/odom": [], "/camera": []}
    recorder: RecordNode = stage.add(RecordNode())
    stage.spin_until(lambda: bool(answers))
    assert answers[0].header.stamp.sec == 2**31 - 1
    said = publish_run(source, 15)
    source.create_publisher(String, "late", LATCHED).publish(String(data="found later"))
    stage.spin_until(lambda: recorder.recorded >= 15 * 3 + 2)
    stage.close()
    with Bag(bag) as opened:
        heard: dict[str, list[bytes]] = {}
        for message in opened.messages():
            heard.setdefault(message.topic, []).append(message.raw)
            if message.topic in said:
                x = len(heard[message.topic])
                assert message.log_ns == x * STEP_NS, "a message's time is its stamp"
        assert {topic: heard[topic] for topic in said} == said
        assert heard["/map"] == [serialize_message(String(data="the floor"))]
        assert heard["/late"] == [serialize_message(String(data="found later"))]
        assert opened.topics["/map"].offers[0].durability == "transient_local"
        assert opened.topics["/camera"].offers[0].reliability == "best_effort"
        assert opened.topics["/odom"].type_hash.startswith("RIHS01_")
        assert "/record/status" not in opened.topics


def test_what_has_no_time_at_all_is_filed_as_received(staged: Staged, bag: Path) -> None:
    """No clock and no stamps: a little is kept for the first of them, more is not held back."""
    stage = staged(Stage, path=bag, require="text", find_every_s=0.02)
    source = stage.add(Node("source"))
    text = source.create_publisher(String, "text", CYCLE)
    answers: list[NodeStatus] = []
    source.create_subscription(NodeStatus, "record/status", answers.append, LATCHED)
    recorder: RecordNode = stage.add(RecordNode())
    stage.spin_until(lambda: bool(answers))
    began_ns = time.time_ns()
    for count in range(1, 13):
        text.publish(String(data="x" * 100_000))
        stage.spin_until(lambda count=count: recorder.heard >= count)  # type: ignore[misc]
    assert recorder.recorded >= 11
    stage.close()
    with Bag(bag) as opened:
        times = [message.log_ns for message in opened.messages()]
    assert len(times) == 12
    assert all(began_ns <= time_ns <= time.time_ns() for time_ns in times)


def record_cycles(bag: Path, steps: int, *, lag_ns: int = 0) -> None:
    """Record odometry, looks and events of a run; events are logged ``lag_ns`` after their stamp."""
    with Recorder(bag) as recorder:
        recorder.add_topic("/map", STRING, (LATCHED_OFFER,))
        recorder.write("/map", STRING, string_cdr("floor"), 0)
        kind = "geometry_msgs/msg/Vector3Stamped"
        for topic in ("/odom", "/landmarks", "/gvg/events"):
            recorder.add_topic(topic, kind, (OfferedQos(depth=16, durability="transient_local"),))
        for step in range(1, steps + 1):
            stamp_ns = step * STEP_NS
            raw = serialize_message(vector(stamp_ns, float(step)))
            recorder.write("/odom", kind, raw, stamp_ns)
            if step % 2 == 0:
                recorder.write("/landmarks", kind, raw, stamp_ns)
            if step % 5 == 0:
                recorder.write("/gvg/events", kind, raw, stamp_ns + lag_ns)
            status = serialize_message(NodeStatus(node="ekf", state="recorded"))
            recorder.write("/ekf/status", "hslam_msgs/msg/NodeStatus", status, stamp_ns)


class Listener(Node):
    """Plays the live ekf: keeps the order in which it hears things, and answers when told to."""

    def __init__(self) -> None:
        super().__init__("ekf")
        self.heard: list[tuple[str, int]] = []
        self.promised: dict[str, int] = {}
        self.maps: list[String] = []
        self.clock: list[int] = []
        for topic in ("odom", "landmarks", "gvg/events"):
            self.create_subscription(Vector3Stamped, topic, lambda msg, topic=topic: self._hear(topic, msg), CYCLE)
        for source in ("sim", "gvg"):
            self.create_subscription(NodeStatus, f"{source}/status", self._promise, CYCLE)
        self.create_subscription(String, "map", self.maps.append, LATCHED)
        self.create_subscription(Clock, "/clock", lambda msg: self.clock.append(stamp_from_msg(msg.clock)), CYCLE)
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)

    def _hear(self, topic: str, msg: Vector3Stamped) -> None:
        self.heard.append((topic, round(msg.vector.x)))

    def _promise(self, msg: NodeStatus) -> None:
        self.promised[msg.node] = msg.outputs

    def count(self, topic: str) -> int:
        return sum(name == topic for name, _ in self.heard)

    def answer(self, step: int) -> None:
        msg = NodeStatus(node="ekf")
        msg.header.stamp = stamp_to_msg(step * STEP_NS)
        self._status.publish(msg)


@pytest.mark.parametrize("lag_ns", [0, STEP_NS + STEP_NS // 2])
def test_lock_step_waits_for_each_answer_and_promises_what_it_sent(staged: Staged, bag: Path, lag_ns: int) -> None:
    steps = 40
    record_cycles(bag, steps, lag_ns=lag_ns)
    stage = staged(Stage, path=bag, lockstep=True, live="ekf")
    ekf: Listener = stage.add(Listener())
    replay: ReplayNode = stage.add(ReplayNode())
    for step in range(1, steps + 1):
        due = {"odom": step, "landmarks": step // 2, "gvg/events": step // 5}
        stage.spin_until(
            lambda step=step, due=due: (  # type: ignore[misc]
                {name: ekf.count(name) for name in due} == due
                and ekf.promised == {"sim": due["landmarks"], "gvg": due["gvg/events"]}
                and ekf.clock[-1:] == [step * STEP_NS]
            )
        )
        assert not replay.finished
        ekf.answer(step)
    stage.spin_until(lambda: replay.finished)
    assert [step for topic, step in ekf.heard if topic == "odom"] == list(range(1, steps + 1))
    assert [msg.data for msg in ekf.maps] == ["floor"]


def test_lock_step_names_a_node_that_does_not_answer(staged: Staged, bag: Path) -> None:
    record_cycles(bag, 5)
    stage = staged(Stage, path=bag, lockstep=True, live="ekf,atlas", start_within_s=0.3)
    ekf: Listener = stage.add(Listener())
    replay: ReplayNode = stage.add(ReplayNode())
    stage.spin_until(lambda: ekf.count("odom") == 1)
    ekf.answer(1)
    stage.spin_until(lambda: replay.failure is not None)
    assert "no answer from atlas to the cycle at 0.12 s" in str(replay.failure)


def test_replays_at_a_rate_with_pause_and_step(staged: Staged, bag: Path) -> None:
    steps = 50
    record_cycles(bag, steps)
    stage = staged(Stage, path=bag, rate=50.0, paused=True, delay_s=0.0, start_s=10 * STEP_NS * 1e-9, topics="odom,map")
    ekf: Listener = stage.add(Listener())
    replay: ReplayNode = stage.add(ReplayNode())
    calls = {name: ekf.create_client(Trigger, f"/replay/{name}") for name in ("step", "resume")}
    assert all(client.wait_for_service(10.0) for client in calls.values())
    for expected in (10, 11, 12):
        answer = calls["step"].call_async(Trigger.Request())
        stage.spin_until(lambda expected=expected: ekf.heard[-1:] == [("odom", expected)])  # type: ignore[misc]
        stage.spin_until(answer.done)
        assert answer.result().message == f"at rest at {expected * 0.12:.3f} s"
    began = time.monotonic()
    calls["resume"].call_async(Trigger.Request())
    stage.spin_until(lambda: replay.finished)
    assert time.monotonic() - began >= (steps - 12) * 0.12 / 50.0
    stage.spin_until(lambda: ekf.count("odom") == steps - 9)
    assert ekf.heard == [("odom", step) for step in range(10, steps + 1)]
    assert ekf.clock == sorted(ekf.clock)


def test_a_gap_of_years_is_passed_over(staged: Staged, bag: Path) -> None:
    since_1970_ns = 1_700_000_000 * 10**9
    with Recorder(bag) as recorder:
        for time_ns in (0, since_1970_ns, since_1970_ns + 10**8):
            recorder.write("/note", STRING, serialize_message(String(data=str(time_ns))), time_ns)
    stage = staged(Stage, path=bag, delay_s=0.0, max_gap_s=5.0)
    replay: ReplayNode = stage.add(ReplayNode())
    stage.spin_until(lambda: replay.finished)
    assert replay.published == 3


def test_refuses_what_cannot_be_replayed(staged: Staged, bag: Path) -> None:
    with Recorder(bag) as recorder:
        recorder.write("/chatter", STRING, b"\0\1\0\0\xff\xff\xff\x7fno string is that long", 1)
    stage = staged(Stage, path=bag, delay_s=0.0)
    replay: ReplayNode = stage.add(ReplayNode())
    stage.spin_until(lambda: replay.failure is not None)
    assert "bag: topic /chatter, message at 1 ns: does not decode as std_msgs/msg/String" in str(replay.failure)
    stage.close()
    refusals: list[tuple[dict[str, object], type[HslamError], str]] = [
        ({"lockstep": True, "live": "ekf"}, BagError, "topic /odom: is not replayed, though it gives lock-step"),
        ({"start_s": 5.0}, BagError, "holds no message to replay after the start"),
        ({"lockstep": True}, ConfigurationError, "lock-step waits for the answers of the nodes in 'live'"),
    ]
    for parameters, kind, text in refusals:
        stage = staged(Stage, path=bag, **parameters)
        with pytest.raises(kind, match=text):
            ReplayNode()
        stage.close()


RECORD = [sys.executable, "-c", "from hslam_bags.record_node import main; main()", "--ros-args"]


@pytest.mark.parametrize(("ending", "status"), [(signal.SIGINT, 0), (signal.SIGTERM, 0), (signal.SIGKILL, -9)])
def test_however_it_ends_the_bag_opens(staged: Staged, bag: Path, ending: signal.Signals, status: int) -> None:
    stage = staged(Stage)
    source = stage.add(Node("source"))
    answers: list[NodeStatus] = []
    source.create_subscription(NodeStatus, "record/status", answers.append, LATCHED)
    publish_run(source, 0)
    command = [*RECORD, "-p", f"path:={bag}", "-p", "require:=odom", "-p", "flush_every_s:=0.05"]
    process = subprocess.Popen(command)
    try:
        stage.spin_until(lambda: bool(answers))
        publish_run(source, 15)
        stage.spin_until(lambda: _counted(bag, "/odom") == 15)
        process.send_signal(ending)
        assert process.wait(20) == status
    finally:
        process.kill()
        process.wait()
    with Bag(bag) as opened:
        assert sum(message.topic == "/odom" for message in opened.messages()) == 15


def _counted(bag: Path, topic: str) -> int:
    """Return how many messages of a topic a bag holds that is being recorded."""
    try:
        with Bag(bag) as opened:
            return opened.counts.get(topic, 0)
    except BagError:
        return -1


def test_a_bag_that_cannot_be_written_ends_the_node_with_one_line(staged: Staged, bag: Path) -> None:
    """What a full disk leaves behind is tested with the recorder; here, that the node ends and says why."""
    stage = staged(Stage)
    source = stage.add(Node("source"))
    answers: list[NodeStatus] = []
    source.create_subscription(NodeStatus, "record/status", answers.append, LATCHED)
    publish_run(source, 0)
    command = [*RECORD, "-p", f"path:={bag}", "-p", "require:=odom", "-p", "flush_every_s:=0.05"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        stage.spin_until(lambda: bool(answers))
        bag.rename(bag.with_name("gone"))  # at once: the recorder writes meanwhile
        publish_run(source, 15)
        stage.spin_until(lambda: process.poll() is not None)
        _, err = process.communicate()
    finally:
        process.kill()
    assert process.returncode == 1
    (line,) = err.splitlines()
    assert line.startswith(f"record: {bag / 'metadata.yaml'}: no such file or directory")


def test_a_bad_start_is_one_line(bag: Path) -> None:
    bag.mkdir()
    (bag / "thesis.txt").write_text("precious")
    command = [*RECORD, "-p", f"path:={bag}"]
    run = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 1
    assert [line for line in run.stderr.splitlines() if "not empty; nothing is overwritten" in line]
    assert "Traceback" not in run.stderr
