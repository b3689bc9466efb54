"""Does the recorder keep up: `python bench/bags_recording.py [--factor N] [--seconds N]`, in the sourced workspace.

Publishes what a run does, 20 messages a step, at N times 170 steps a second (20 times real time), to `record_node` as
a separate process, and counts what the bag holds. Then the cost of `Recorder.write` alone, in CPU time of this process.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil
import rclpy
from hslam_msgs.msg import NodeStatus, SonarRing
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.serialization import serialize_message

from hslam_bags.bag import Bag
from hslam_bags.recorder import Recorder
from hslam_ros.private_domain import private_domain
from hslam_ros.qos import CYCLE, LATCHED
from hslam_ros.stamps import stamp_to_msg

TOPICS = 20
STEPS_PER_S = 170.0
STEP_NS = 120_000_000


def wait_for_recorder(node: Node) -> None:
    """Return once the recorder says that it hears everything."""
    answers: list[NodeStatus] = []
    node.create_subscription(NodeStatus, "record/status", answers.append, LATCHED)
    while not answers:
        rclpy.spin_once(node, timeout_sec=0.1)


def through_the_node(folder: Path, factor: float, seconds: float) -> str:
    """Publish to `record_node` and return a line of figures."""
    topics = [f"sensor_{index}" for index in range(TOPICS)]
    command = [sys.executable, "-c", "from hslam_bags.record_node import main; main()", "--ros-args"]
    command += ["-p", f"path:={folder}", "-p", f"require:={','.join(topics)}"]
    recorder = subprocess.Popen(command)
    try:
        rclpy.init()
        node = rclpy.create_node("source")
        publishers = [node.create_publisher(Odometry, topic, CYCLE) for topic in topics]
        wait_for_recorder(node)
        steps = round(STEPS_PER_S * factor * seconds)
        msg = Odometry()
        used_before_s = sum(psutil.Process(recorder.pid).cpu_times()[:2])
        period_s = 1.0 / (STEPS_PER_S * factor)
        began = due_s = time.monotonic()
        for step in range(1, steps + 1):
            msg.header.stamp = stamp_to_msg(step * STEP_NS)
            raw = serialize_message(msg)
            for publisher in publishers:
                publisher.publish(raw)
            # No bursts to catch up: a step follows the one before no sooner than the rate says.
            due_s += period_s
            late_s = time.monotonic() - due_s
            time.sleep(max(0.0, -late_s))
            due_s += max(0.0, late_s)
        took_s = time.monotonic() - began
        for publisher in publishers:
            publisher.wait_for_all_acked()
        used_s = sum(psutil.Process(recorder.pid).cpu_times()[:2]) - used_before_s
        recorder.send_signal(signal.SIGINT)
        recorder.wait(30)
        rclpy.shutdown()
    finally:
        recorder.kill()
        recorder.wait()
    with Bag(folder) as bag:
        kept = sum(bag.counts[f"/{topic}"] for topic in topics)
    sent = steps * TOPICS
    size_mb = sum(file.stat().st_size for file in folder.iterdir()) / 1e6
    return (
        f"{factor:g} times the suite: {sent} messages in {took_s:.1f} s ({sent / took_s:.0f}/s), {sent - kept} lost, "
        f"recorder at {100 * used_s / took_s:.0f} % of a core, {size_mb:.1f} MB"
    )


def alone(folder: Path) -> str:
    """Write messages of a run's sizes and return a line of figures."""
    rng = random.Random(1)
    ring = SonarRing(ranges=[rng.random() for _ in range(16)], bearings=[rng.random() for _ in range(16)])
    raws = [serialize_message(ring) for _ in range(100)]
    count = 200_000
    with Recorder(folder) as recorder:
        began = time.process_time()
        for index in range(count):
            recorder.write(f"/t{index % TOPICS}", "hslam_msgs/msg/SonarRing", raws[index % 100], index * 1000)
        used_s = time.process_time() - began
    return (
        f"Recorder.write: {1e6 * used_s / count:.1f} us a message of {len(raws[0])} bytes, packing and writing included"
    )


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--factor", type=float, default=5.0)
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch, private_domain() as domain:
        os.environ.update(domain.environment)
        print(through_the_node(Path(scratch) / "node", options.factor, options.seconds))
        print(alone(Path(scratch) / "alone"))


if __name__ == "__main__":
    main()
