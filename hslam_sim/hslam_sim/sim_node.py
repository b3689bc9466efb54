"""The simulator as a node: publishes each step's readings and takes the next step when they are answered."""

import functools
import time
from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from hslam_msgs.msg import LandmarkObservations, NodeStatus, SonarRing
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMsg
from sensor_msgs.msg import BatteryState, LaserScan
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from hslam_ros import conversions
from hslam_ros.door import Door, stamped
from hslam_ros.lock_step import LockStep, Patience
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE, LATCHED, SENSOR
from hslam_ros.scan_conversion import scan_to_msg
from hslam_ros.spin import run
from hslam_ros.stamps import NS_PER_S, stamp_to_msg
from hslam_ros.transforms import transform_to_msg
from hslam_sim import sim_messages
from hslam_sim.base_configuration import BaseConfiguration
from hslam_sim.battery import BatteryConfiguration
from hslam_sim.landmark_sensor import LandmarkConfiguration
from hslam_sim.lidar_configuration import LidarConfiguration
from hslam_sim.passers_by import PassersByConfiguration
from hslam_sim.run_configuration import RunConfiguration
from hslam_sim.simulation import ClockConfiguration, SimStep, Simulation, SimulationConfiguration
from hslam_sim.sonar_configuration import SonarConfiguration
from hslam_sim.worlds import load_world
from hslam_types.answer import Answer
from hslam_types.sensing import Velocity

COMMAND = "cmd_vel"
_LAST_WORDS_S = 1.0
LOCKSTEP_NODES = ["atlas"]
SUSPECTS = ["gvg", "ekf"]


class SimNode(Node):
    """Owns the simulation and its topics."""

    def __init__(self) -> None:
        """Load the world and publish the first step; raises HslamError on a bad parameter or world."""
        super().__init__("sim")
        self._run = declare(self, RunConfiguration)
        world = load_world(self._run.world, landmark_seed=self._run.landmark_seed)
        if (start := self._run.start_in_world) is not None:
            world = replace(world, start=start)
        self._simulation = Simulation(world, self._configuration(), self._run.seed)
        self._finished = False
        self._complete_ns: int | None = None
        self._command: Velocity | None = None
        self._last: SimStep | None = None
        self._next: SimStep | None = None
        self._door = Door(self)
        self._create_publishers()
        self._finish_service = self.create_service(Trigger, "~/finish", self._on_finish)
        run = self._run
        awaited = self._names("lockstep_nodes", LOCKSTEP_NODES, "nodes that answer a step before the one after next")
        about = "nodes that those wait for themselves: asked when an answer is late, to name the one at fault"
        self._suspects = self._names("lockstep_suspects", SUSPECTS, about)
        prompt, trailing = ([COMMAND], awaited) if run.lockstep else ([], [])
        self._lock_step = LockStep(prompt, run.warn_after_s, run.fail_after_s, run.start_within_s, trailing)
        profile = CYCLE if run.lockstep else SENSOR
        command = stamped(conversions.velocity_from_msg)
        self._door.hear(TwistStamped, COMMAND, command, self._on_command, profile, self._on_refused_command)
        for name in awaited:
            self._hear(name)
        if not run.lockstep:
            period_s = self._simulation.config.clock.step_s / run.real_time_factor
            self._timer = self.create_timer(period_s, self._step, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._step()

    def over(self) -> bool:
        """Return whether the run has ended; raises LockStepError when a node has kept it waiting too long."""
        if not self._finished and self._lock_step.check(time.monotonic()) is Patience.WARN:
            missing = ", ".join(self._lock_step.missing())
            self.get_logger().warning(f"waiting for {missing} at {self._now_s():.2f} s")
            while self._suspects:
                self._lock_step.await_also(self._suspects[0])
                self._hear(self._suspects.pop(0))
        return self._finished

    def close(self) -> None:
        """After a run that ended well, let every listener have the last step before the topics go."""
        if self._finished:
            for topic in (self._odom, self._sonar, self._landmarks, self._truth, self._clock_topic):
                topic.wait_for_all_acked(Duration(seconds=_LAST_WORDS_S))

    def _names(self, parameter: str, default: list[str], about: str) -> list[str]:
        descriptor = ParameterDescriptor(description=about, read_only=True)
        return [name for name in self.declare_parameter(parameter, default, descriptor).value if name]

    def _hear(self, name: str) -> None:
        answered = functools.partial(self._on_answer, name)
        self._door.hear(NodeStatus, f"{name}/status", conversions.answer_from_msg, answered, CYCLE)

    def _configuration(self) -> SimulationConfiguration:
        return SimulationConfiguration(
            clock=declare(self, ClockConfiguration, "clock."),
            base=declare(self, BaseConfiguration, "base."),
            sonar=declare(self, SonarConfiguration, "sonar."),
            landmarks=declare(self, LandmarkConfiguration, "landmarks."),
            lidar=declare(self, LidarConfiguration, "lidar."),
            people=declare(self, PassersByConfiguration, "people."),
            battery=declare(self, BatteryConfiguration, "battery."),
        )

    def _create_publishers(self) -> None:
        self._clock_topic = self.create_publisher(ClockMsg, "/clock", CYCLE)
        self._odom = self.create_publisher(Odometry, "odom", CYCLE)
        self._sonar = self.create_publisher(SonarRing, "sonar", CYCLE)
        self._scan = self.create_publisher(LaserScan, "scan", CYCLE)
        self._landmarks = self.create_publisher(LandmarkObservations, "landmarks", CYCLE)
        self._truth = self.create_publisher(Odometry, "ground_truth", CYCLE)
        # Looks come every few cycles: the count tells listeners whether this cycle's is still on its way.
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)
        self._looks = 0
        self._tf = self.create_publisher(TFMessage, "/tf", 100)
        self._bumper = self.create_publisher(Bool, "bumper", LATCHED)
        self._battery = self.create_publisher(BatteryState, "battery", LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def _on_command(self, said: tuple[int, Velocity]) -> None:
        stamp_ns, self._command = said
        if self._run.lockstep:
            if self._last is not None and stamp_ns == self._last.stamp_ns and self._next is None:
                self._next = self._advance()  # what comes of the command, while the others still think
            self._answer(COMMAND, stamp_ns)

    def _on_refused_command(self, stamp_ns: int | None) -> None:
        """Stop the base: who commands what is no number has lost it."""
        if stamp_ns is not None:
            self._on_command((stamp_ns, Velocity()))

    def _on_answer(self, name: str, answer: Answer) -> None:
        if answer.finished and self._complete_ns is None:
            self._complete_ns = answer.stamp_ns
        if self._run.lockstep:
            self._answer(name, answer.stamp_ns)
        else:
            self._finished |= answer.finished

    def _answer(self, name: str, stamp_ns: int) -> None:
        """Note an answer; with the last one publish the next step, or end after the one that followed the last."""
        self._lock_step.answer(name, stamp_ns)
        if self._finished or self._lock_step.missing():
            return
        if self._complete_ns is not None and self._complete_ns < self._lock_step.stamp_ns:
            self._finished = True
        else:
            self._step()

    def _step(self) -> None:
        step, self._next = self._next or self._advance(), None
        self._lock_step.expect(step.stamp_ns, time.monotonic())
        self._publish(step)
        self._last = step

    def _advance(self) -> SimStep:
        command, self._command = self._command, None
        return self._simulation.step(command)

    def _now_s(self) -> float:
        return self._last.stamp_ns / NS_PER_S if self._last is not None else 0.0

    def _publish(self, step: SimStep) -> None:
        """Publish a step: first what others wait for (odometry opens their cycle), then the rest while they work."""
        before = self._last
        if step.landmarks is not None:
            self._looks += 1
            self._landmarks.publish(conversions.landmarks_to_msg(step.landmarks))
        if step.scan is not None:
            self._scan.publish(scan_to_msg(step.scan))
        self._sonar.publish(conversions.sonar_to_msg(step.sonar))
        self._odom.publish(conversions.odometry_to_msg(step.odom))
        about = conversions.header(step.stamp_ns, "")
        self._status.publish(NodeStatus(header=about, node=self.get_name(), outputs=self._looks))
        self._clock_topic.publish(ClockMsg(clock=stamp_to_msg(step.stamp_ns)))
        self._truth.publish(sim_messages.truth_to_msg(step))
        self._tf.publish(transform_to_msg(step.stamp_ns, "odom", "base_link", step.odom.base_in_odom))
        if before is None or step.bumped != before.bumped:
            self._bumper.publish(Bool(data=step.bumped))
        if before is None or step.stamp_ns // NS_PER_S != before.stamp_ns // NS_PER_S:
            self._battery.publish(sim_messages.battery_to_msg(step.stamp_ns, step.battery))
            self._diagnostics.publish(sim_messages.diagnostics_to_msg(step, self._door.refused))

    def _on_finish(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._finished = True
        response.success = True
        response.message = f"ended at {self._now_s():.2f} s of simulated time"
        return response


def main() -> None:
    """Run the node until a status says that the mission is complete, its `finish` service is called, or a signal."""
    run(SimNode, done=lambda node: isinstance(node, SimNode) and node.over())
