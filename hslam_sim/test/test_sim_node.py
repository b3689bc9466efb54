"""The simulator's node: lock-step changes no bit, names who is missing, and ends as it should."""

import math
import signal
import subprocess
import sys
from collections.abc import Callable

import pytest
from geometry_msgs.msg import TwistStamped
from hslam_msgs.msg import LandmarkObservations, NodeStatus, SonarRing
from nav_msgs.msg import Odometry
from rclpy.node import Node
from ros_stage import Stage, Staged
from std_srvs.srv import Trigger

from hslam_ros import conversions
from hslam_ros.lock_step import LockStepError
from hslam_ros.qos import CYCLE
from hslam_sim.sim_node import SimNode
from hslam_sim.simulation import Simulation
from hslam_sim.worlds import load_world
from hslam_types.sensing import LandmarkView, OdometrySample, SonarSweep, Velocity

NODES = ("gvg", "ekf", "atlas")
Command = Callable[[int], Velocity]
RUN = "from hslam_sim.sim_node import main; main()"


def command(stamp_ns: int) -> Velocity:
    """Return the command that answers a stamp."""
    return Velocity(0.3, 0.5 * math.sin(stamp_ns * 1e-9))


class Suite(Node):
    """Answers each cycle as the rest of the suite would, and keeps what it heard."""

    def __init__(self, answering: tuple[str, ...] = NODES, finish_ns: int = 2**62, command: Command = command) -> None:
        super().__init__("suite")
        self._command_to = command
        self.odom: list[OdometrySample] = []
        self.sonar: list[SonarSweep] = []
        self.landmarks: list[LandmarkView] = []
        self._finish_ns = finish_ns
        self._cmd_vel = self.create_publisher(TwistStamped, "cmd_vel", CYCLE)
        self._statuses = [self.create_publisher(NodeStatus, f"{name}/status", CYCLE) for name in answering]
        self.create_subscription(Odometry, "odom", self._on_odom, CYCLE)
        self.create_subscription(SonarRing, "sonar", self._on_sonar, CYCLE)
        self.create_subscription(
            LandmarkObservations,
            "landmarks",
            lambda msg: self.landmarks.append(conversions.landmarks_from_msg(msg)),
            CYCLE,
        )

    def _on_odom(self, msg: Odometry) -> None:
        self.odom.append(conversions.odometry_from_msg(msg))
        self._answer()

    def _on_sonar(self, msg: SonarRing) -> None:
        self.sonar.append(conversions.sonar_from_msg(msg))
        self._answer()

    def _answer(self) -> None:
        """Answer a cycle once its odometry and sonar have come, as gvg does.

        Answered sooner, the next ping may be said before the first listener of sonar is found, and DDS loses the first.
        """
        if not (self.odom and self.sonar) or self.odom[-1].stamp_ns != self.sonar[-1].stamp_ns:
            return
        stamp_ns = self.odom[-1].stamp_ns
        self._cmd_vel.publish(conversions.velocity_to_msg(self._command_to(stamp_ns), stamp_ns))
        for topic in self._statuses:
            topic.publish(NodeStatus(header=conversions.header(stamp_ns, ""), finished=stamp_ns >= self._finish_ns))


def test_lock_step_gives_the_bits_of_the_simulation_in_process(staged: Staged) -> None:
    """Steps through the middleware are those of a plain loop; the mission's end ends the node one step later."""
    stage = staged(Stage, world="small_world", seed=3, landmark_seed=2)
    sim, suite = stage.add(SimNode()), stage.add(Suite(finish_ns=59 * 120_000_000))
    stage.spin_until(sim.over)
    plain = Simulation(load_world("small_world", landmark_seed=2), seed=3)
    steps, answer = [], None
    for _ in range(60):
        steps.append(plain.step(answer))
        answer = command(plain.stamp_ns)
    pair = [conversions.odometry_from_msg(conversions.odometry_to_msg(step.odom)) for step in steps]
    assert suite.odom == pair
    assert suite.sonar == [step.sonar for step in steps]
    assert suite.landmarks == [step.landmarks for step in steps if step.landmarks is not None]


def test_a_command_that_is_no_number_stops_the_base_and_holds_nothing_up(staged: Staged) -> None:
    stage = staged(Stage, world="small_world")
    lost_ns = 20 * 120_000_000
    suite = Suite(finish_ns=59 * 120_000_000, command=lambda at: Velocity(math.nan if at > lost_ns else 0.2, 0.0))
    sim, suite = stage.add(SimNode()), stage.add(suite)
    stage.spin_until(sim.over)
    assert len(suite.odom) == 60
    assert suite.odom[20].velocity.forward > 0.1
    assert suite.odom[-1].velocity.forward == pytest.approx(0.0, abs=1e-6)
    assert sim._door.report() == "refused messages: cmd_vel 40"


def test_a_silent_node_is_named_and_ends_the_run(staged: Staged) -> None:
    """When ekf is silent, and so atlas, which waits for it, the error says so, and says nothing of gvg."""
    stage = staged(Stage, world="small_world", warn_after_s=0.1, fail_after_s=0.2, start_within_s=0.5)
    sim, suite = stage.add(SimNode()), stage.add(Suite(answering=("gvg",)))
    with pytest.raises(LockStepError, match=r"no answer from atlas, ekf$"):
        stage.spin_until(sim.over)
    assert len(suite.odom) == 2, "others may trail by one step"


def test_running_freely_waits_for_nobody_and_finish_ends_it(staged: Staged) -> None:
    """Steps come by the clock without any answer, until the service is called."""
    stage = staged(Stage, world="small_world", lockstep="false", real_time_factor=20.0)
    sim, suite = stage.add(SimNode()), stage.add(Suite(answering=()))
    stage.spin_until(lambda: len(suite.odom) >= 20)
    assert stage.call(suite, Trigger, "sim/finish", Trigger.Request()).success
    assert sim.over()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-p", "world:=nowhere"], "nowhere"),
        (["-p", "sonar.noise_fraction:=7.0"], "sonar.noise_fraction"),
        (["-p", "base.body_radius_m:=wide"], "base.body_radius_m"),
        (["-p", "sonar.noise:=0.1"], "unknown parameter 'sonar.noise'"),
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
def test_a_signal_ends_the_executable_well(staged: Staged, number: signal.Signals) -> None:
    """Interrupted while it waits for the others, it exits with 0."""
    stage = staged(Stage)
    listener = stage.add(Node("listener"))
    heard: list[Odometry] = []
    listener.create_subscription(Odometry, "odom", heard.append, CYCLE)
    process = subprocess.Popen([sys.executable, "-c", RUN], stderr=subprocess.PIPE)
    try:
        stage.spin_until(lambda: len(heard) > 0)
        process.send_signal(number)
        assert process.wait(10) == 0
    finally:
        process.kill()
        process.communicate()
