"""`hslam record` and `hslam replay` as a person uses them, against a node that talks and listens."""

import signal
from pathlib import Path

from hslam_msgs.msg import NodeStatus
from rclpy.node import Node
from rclpy.task import Future
from ros_stage import Stage, Staged
from std_msgs.msg import String
from std_srvs.srv import Trigger
from whole_runs import hslam, outcome

from hslam_bags.bag import Bag
from hslam_bags.errors import BagError
from hslam_ros.conversions import header
from hslam_ros.qos import CYCLE

STEP_NS = 100_000_000
STEPS = 30


def recorded(bag: Path) -> dict[str, int]:
    """Return the counts of a bag, by topic, that may still be on its way."""
    try:
        with Bag(bag) as opened:
            return dict(opened.counts)
    except BagError:
        return {}


def test_what_was_recorded_in_several_files_is_said_again(staged: Staged, tmp_path: Path) -> None:
    stage = staged(Stage)
    source = stage.add(Node("source"))
    wanted = source.create_publisher(NodeStatus, "said", CYCLE)
    unwanted = source.create_publisher(String, "muttered", CYCLE)
    bag = tmp_path / "bag"
    run = hslam("record", str(bag), "--topic", "/said", "--topic", "/mut.*", "--exclude", "/muttered", "--split-s", "1")
    stage.spin_until(lambda: wanted.get_subscription_count() > 0)
    for i in range(STEPS):
        wanted.publish(NodeStatus(header=header((i + 1) * STEP_NS, ""), outputs=i))
        unwanted.publish(String(data="not for the record"))
    stage.spin_until(lambda: recorded(bag).get("/said") == STEPS)
    run.send_signal(signal.SIGINT)
    assert outcome(run, within_s=30.0)[0] == 0
    assert recorded(bag) == {"/said": STEPS}
    assert len(list(bag.glob("*.mcap"))) == 3

    stage.close()  # what the source said is latched: it must be gone
    stage = staged(Stage)
    listener = stage.add(Node("listener"))
    heard: list[NodeStatus] = []
    listener.create_subscription(NodeStatus, "said", heard.append, CYCLE)
    resume, pause = (listener.create_client(Trigger, f"replay/{name}") for name in ("resume", "pause"))
    again = hslam("replay", str(bag), "--rate", "20", "--paused")
    stage.spin_until(pause.service_is_ready)
    asked: list[Future] = []

    def found() -> bool:
        """An answer proves that the replay has found all that this node made before; one sent too early is lost."""
        asked.append(pause.call_async(Trigger.Request()))
        return any(answer.done() for answer in asked)

    stage.spin_until(found)
    assert stage.wait(resume.call_async(Trigger.Request())).success
    stage.spin_until(lambda: len(heard) >= STEPS)
    assert outcome(again, within_s=30.0)[0] == 0
    assert [(status.outputs, status.header.stamp.nanosec) for status in heard] == [
        (i, (i + 1) * STEP_NS % 1_000_000_000) for i in range(STEPS)
    ]
