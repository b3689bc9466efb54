"""The node and the emulator as processes, over a pseudo-terminal and TCP: topics, life cycle, lock-step, death."""

import itertools
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from hslam_msgs.msg import LandmarkObservations, NodeStatus, SonarRing
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nav_msgs.msg import Odometry
from rclpy.node import Node
from ros_stage import Stage, Staged, ros_arguments

from hslam_ros.conversions import velocity_to_msg
from hslam_ros.qos import CYCLE, SENSOR
from hslam_ros.stamps import stamp_from_msg
from hslam_types.sensing import Velocity

PATIENCE_S = 20.0
TOPICS: dict[str, Any] = {
    "odom": Odometry,
    "sonar": SonarRing,
    "landmarks": LandmarkObservations,
    "ground_truth": Odometry,
    "/diagnostics": DiagnosticArray,
}


class Scene(Stage):
    """Processes under test and a node that listens and commands."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.line = str(folder / "line")
        self.heard: dict[str, list[Any]] = {name: [] for name in TOPICS}
        self._node = self.add(Node("onlooker"))
        for name, kind in TOPICS.items():
            self._node.create_subscription(kind, name, self.heard[name].append, CYCLE if name == "odom" else SENSOR)
        self._commands = self._node.create_publisher(TwistStamped, "cmd_vel", CYCLE)
        # Made early: a process that has not found a client's reader yet loses its answer.
        self._change_state = self._node.create_client(ChangeState, "scout/change_state")
        self._processes: list[subprocess.Popen[bytes]] = []

    def start(self, executable: str, **parameters: object) -> subprocess.Popen[bytes]:
        """Start one of the package's executables."""
        command = [sys.executable, "-m", f"scout_driver.{executable}", *ros_arguments(parameters)]
        self._processes.append(subprocess.Popen(command))
        return self._processes[-1]

    def command(self, forward: float, stamp_ns: int = 0) -> None:
        """Command a velocity."""
        self._commands.publish(velocity_to_msg(Velocity(forward, 0.0), stamp_ns))

    def change_state(self, transition: int) -> bool:
        """Ask the driver's node for a transition; tell whether it was made."""
        request = ChangeState.Request(transition=Transition(id=transition))
        self.spin_until(self._change_state.service_is_ready)
        return bool(self.wait(self._change_state.call_async(request)).success)

    def answer_like(self, *nodes: str, forward: float) -> None:
        """Answer every odometry as the suite's nodes do."""
        statuses = [self._node.create_publisher(NodeStatus, f"{name}/status", CYCLE) for name in nodes]

        def answer(odom: Odometry) -> None:
            for publisher in statuses:
                publisher.publish(NodeStatus(header=odom.header))
            self.command(forward, stamp_from_msg(odom.header.stamp))

        self._node.create_subscription(Odometry, "odom", answer, CYCLE)

    def command_until(self, forward: float, done: Callable[[], bool]) -> None:
        """Command a velocity again and again until something holds."""

        def commanded() -> bool:
            self.command(forward)
            return done()

        self.spin_until(commanded)

    def close(self) -> None:
        """Stop what still runs."""
        for process in self._processes:
            if process.poll() is None:
                process.kill()
                process.wait()
        super().close()


@pytest.fixture
def scene(staged: Staged, tmp_path: Path) -> Scene:
    return staged(Scene, folder=tmp_path)


def _true_speed(scene: Scene) -> float:
    """True forward speed (m/s) from the last two truths."""
    before, after = scene.heard["ground_truth"][-2:]
    elapsed_s = (stamp_from_msg(after.header.stamp) - stamp_from_msg(before.header.stamp)) * 1e-9
    return abs(float(after.pose.pose.position.x - before.pose.pose.position.x)) / max(elapsed_s, 1e-3)


def _interrupt(process: subprocess.Popen[bytes]) -> int:
    process.send_signal(signal.SIGINT)
    return process.wait(PATIENCE_S)


def test_drives_over_a_pseudo_terminal_and_survives_the_loss_of_either_side(scene: Scene) -> None:
    emulator = scene.start("scout_emulator", port=scene.line)
    driver = scene.start("scout_node", port=scene.line, board_stamps=True, reconnect_s=0.1)
    heard = scene.heard
    scene.command_until(
        0.2,
        lambda: bool(heard["odom"]) and heard["odom"][-1].pose.pose.position.x > 0.2 and len(heard["landmarks"]) > 1,
    )
    odom = {stamp_from_msg(msg.header.stamp) for msg in heard["odom"]}
    assert {stamp_from_msg(msg.header.stamp) for msg in heard["sonar"][2:-2]} <= odom
    looks = [stamp_from_msg(msg.header.stamp) for msg in heard["landmarks"]]
    assert all(later > earlier for earlier, later in itertools.pairwise(looks))
    assert all(stamp % 10_000_000 == 0 for stamp in looks)  # the base's own clock, as the odometry's
    pings = [stamp_from_msg(stamp) for msg in heard["sonar"] for stamp in msg.stamps]
    assert pings == sorted(pings)

    driver.kill()  # no goodbye: the watchdog has to stop the base, and the next driver finds it standing
    driver.wait()
    heard["odom"].clear()
    second = scene.start("scout_node", port=scene.line, board_stamps=True, reconnect_s=0.1)
    scene.spin_until(lambda: len(heard["odom"]) > 20)
    assert _true_speed(scene) == 0.0

    assert _interrupt(emulator) == 0
    heard["/diagnostics"].clear()
    scene.spin_until(lambda: any(msg.status[0].level == b"\x02" for msg in heard["/diagnostics"]))
    scene.start("scout_emulator", port=scene.line)
    heard["odom"].clear()
    scene.spin_until(lambda: len(heard["odom"]) > 5)
    assert _interrupt(second) == 0


def test_deactivating_stops_the_base_and_activating_waits_for_a_new_command(scene: Scene) -> None:
    scene.start("scout_emulator", port=scene.line)
    scene.start("scout_node", port=scene.line, board_stamps=True, reconnect_s=0.1)
    odom = scene.heard["odom"]
    scene.command_until(0.2, lambda: bool(odom) and odom[-1].twist.twist.linear.x > 0.15)
    assert scene.change_state(Transition.TRANSITION_DEACTIVATE)
    odom.clear()
    assert scene.change_state(Transition.TRANSITION_ACTIVATE)
    scene.spin_until(lambda: len(odom) > 10)
    assert {msg.twist.twist.linear.x for msg in odom} == {0.0}
    scene.command_until(0.2, lambda: odom[-1].twist.twist.linear.x > 0.15)


def test_lockstep_steps_once_an_answer_and_ends_when_one_stays_out(scene: Scene) -> None:
    scene.answer_like("gvg", "ekf", forward=0.2)
    emulator = scene.start(
        "scout_emulator", port=scene.line, lockstep=True, lockstep_nodes="[gvg, ekf]", fail_after_s=1.0
    )
    driver = scene.start("scout_node", port=scene.line, lockstep=True, reconnect_s=0.1)
    odom = scene.heard["odom"]
    scene.spin_until(lambda: len(odom) >= 60)
    stamps = [stamp_from_msg(msg.header.stamp) for msg in odom]
    assert {after - before for before, after in itertools.pairwise(stamps)} == {120_000_000}
    assert odom[-1].twist.twist.linear.x == pytest.approx(0.2, abs=0.01)
    looks = [stamp_from_msg(msg.header.stamp) for msg in scene.heard["landmarks"]]
    assert looks[:3] == [360_000_000 * i for i in (1, 2, 3)]
    # This process stops answering: the emulator has to name who is missing, and end.
    assert emulator.wait(PATIENCE_S) == 1
    assert _interrupt(driver) == 0


def test_nothing_listens_on_the_network_unless_asked_to(scene: Scene) -> None:
    scene.start("scout_emulator", port=scene.line)
    driver = scene.start("scout_node", port=scene.line, board_stamps=True)
    scene.spin_until(lambda: bool(scene.heard["odom"]))
    inodes = {str(entry.readlink()) for entry in Path(f"/proc/{driver.pid}/fd").iterdir() if entry.is_symlink()}
    listening = [row.split() for row in Path(f"/proc/{driver.pid}/net/tcp").read_text().splitlines()[1:]]
    own = [row for row in listening if row[3] == "0A" and f"socket:[{row[9]}]" in inodes]
    assert own == []
