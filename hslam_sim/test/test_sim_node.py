"""The simulator's node: lock-step changes no bit, names who is missing, and ends as it should."""

import functools
import math
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from geometry_msgs.msg import TwistStamped
from hslam_msgs.msg import LandmarkObservations, NodeStatus, SonarRing
from nav_msgs.msg import Odometry
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from hslam_ros import conversions
from hslam_ros.lock_step import LockStepError
from hslam_ros.qos import CYCLE
from hslam_ros.stamps import stamp_from_msg
from hslam_sim.sim_node import SimNode
from hslam_sim.simulation import Simulation
from hslam_sim.worlds import load_world
from hslam_types.sensing import LandmarkView, OdometrySample, SonarSweep, Velocity

NODES = ("gvg", "ekf", "atlas")
RUN = "from hslam_sim.sim_node import main; main()"


def command(stamp_ns: int) -> Velocity:
    """Return the command that answers a stamp."""
    return Velocity(0.3, 0.5 * math.sin(stamp_ns * 1e-9))


class Suite(Node):
    """Answers each cycle as the rest of the suite would, and keeps what it heard."""

    def __init__(self, answering: tuple[str, ...] = NODES, finish_ns: int = 2**62) -> None:
        super().__init__("suite")
        self.odom: list[OdometrySample] = []
        self.sonar: list[SonarSweep] = []
        self.landmarks: list[LandmarkView] = []
        self._finish_ns = finish_ns
        self._cmd_vel = self.create_publisher(TwistStamped, "cmd_vel", CYCLE)
        self._statuses = [self.create_publisher(NodeStatus, f"{name}/status", CYCLE) for name in answering]
        self.create_subscription(Odometry, "odom", self._on_odom, CYCLE)
        self.create_subscription(
            SonarRing, "sonar", lambda msg: self.sonar.append(conversions.sonar_from_msg(msg)), CYCLE
        )
        self.create_subscription(
            LandmarkObservations,
            "landmarks",
            lambda msg: self.landmarks.append(conversions.landmarks_from_msg(msg)),
            CYCLE,
        )

    def _on_odom(self, msg: Odometry) -> None:
        self.odom.append(conversions.odometry_from_msg(msg))
        stamp_ns = stamp_from_msg(msg.header.stamp)
        self._cmd_vel.publish(conversions.velocity_to_msg(command(stamp_ns), stamp_ns))
        for topic in self._statuses:
            topic.publish(NodeStatus(header=msg.header, finished=stamp_ns >= self._finish_ns))


Start = Callable[..., SimNode]


@pytest.fixture
def start() -> Iterator[Start]:
    """Give a function that starts the node with parameters; everything is shut down afterwards."""
    nodes: list[SimNode] = []

    def make(**parameters: object) -> SimNode:
        arguments = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
        rclpy.init(args=["--ros-args", *arguments], signal_handler_options=SignalHandlerOptions.NO)
        nodes.append(SimNode())
        return nodes[-1]

    yield make
    for node in nodes:
        node.destroy_node()
    rclpy.try_shutdown()


def spin_until(nodes: list[Node], predicate: Callable[[], bool], timeout_s: float = 20.0) -> None:
    """Run the nodes' callbacks until something holds; fails after ``timeout_s`` of wall time."""
    executor = EventsExecutor()
    for node in nodes:
        executor.add_node(node)
    deadline = time.monotonic() + timeout_s
    while not predicate():
        assert time.monotonic() < deadline, "nothing came in time"
        executor.spin_once(timeout_sec=0.05)
    for node in nodes:
        executor.remove_node(node)


def test_lock_step_gives_the_bits_of_the_simulation_in_process(start: Start) -> None:
    """Steps through the middleware are those of a plain loop; the mission's end ends the node one step later."""
    sim = start(world="small_world", seed=3, landmark_seed=2)
    suite = Suite(finish_ns=59 * 120_000_000)
    spin_until([sim, suite], sim.over)
    plain = Simulation(load_world("small_world", landmark_seed=2), seed=3)
    steps, answer = [], None
    for _ in range(60):
        steps.append(plain.step(answer))
        answer = command(plain.stamp_ns)
    pair = [conversions.odometry_from_msg(conversions.odometry_to_msg(step.odom)) for step in steps]
    assert suite.odom == pair
    assert suite.sonar == [step.sonar for step in steps]
    assert suite.landmarks == [step.landmarks for step in steps if step.landmarks is not None]
    suite.destroy_node()


def test_a_silent_node_is_named_and_ends_the_run(start: Start) -> None:
    """When ekf is silent, and so atlas, which waits for it, the error says so, and says nothing of gvg."""
    sim = start(world="small_world", warn_after_s=0.1, fail_after_s=0.2, start_within_s=0.5)
    suite = Suite(answering=("gvg",))
    with pytest.raises(LockStepError, match=r"no answer from atlas, ekf$"):
        spin_until([sim, suite], sim.over)
    assert len(suite.odom) == 2, "others may trail by one step"
    suite.destroy_node()


def test_running_freely_waits_for_nobody_and_finish_ends_it(start: Start) -> None:
    """Steps come by the clock without any answer, until the service is called."""
    sim = start(world="small_world", lockstep="false", real_time_factor=20.0)
    suite = Suite(answering=())
    spin_until([sim, suite], lambda: len(suite.odom) >= 20)
    client = suite.create_client(Trigger, "sim/finish")
    future = client.call_async(Trigger.Request())
    spin_until([sim, suite], future.done)
    assert future.result().success
    assert sim.over()
    suite.destroy_node()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-p", "world:=nowhere"], "nowhere"),
        (["-p", "sonar.noise_fraction:=7.0"], "sonar.noise_fraction"),
        (["-p", "base.body_radius_m:=wide"], "base.body_radius_m"),
    ],
)
def test_bad_input_is_told_in_one_line(arguments: list[str], message: str) -> None:
    """The executable exits with 1 and says what is wrong, without a traceback."""
    ended = subprocess.run(
        [sys.executable, "-c", RUN, "--ros-args", *arguments], capture_output=True, text=True, timeout=30, check=False
    )
    assert ended.returncode == 1
    assert message in ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_executable_well(number: signal.Signals) -> None:
    """Interrupted while it waits for the others, it exits with 0."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    listener = Node("listener")
    heard: list[Odometry] = []
    listener.create_subscription(Odometry, "odom", heard.append, CYCLE)
    process = subprocess.Popen([sys.executable, "-c", RUN], stderr=subprocess.PIPE)
    try:
        spin_until([listener], functools.partial(bool, heard))
        process.send_signal(number)
        assert process.wait(10) == 0
    finally:
        process.kill()
        process.communicate()
        listener.destroy_node()
        rclpy.try_shutdown()
