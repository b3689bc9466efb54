"""The emulated base as a node: its serial line on a pseudo-terminal or TCP port, and what no serial line carries."""

import dataclasses
import functools
from dataclasses import dataclass

import numpy as np
from hslam_msgs.msg import LandmarkObservations, NodeStatus
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMsg
from std_srvs.srv import Trigger

from hslam_ros.conversions import header, landmarks_to_msg, odometry_to_msg
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE
from hslam_ros.spin import run
from hslam_ros.stamps import stamp_from_msg, stamp_to_msg
from hslam_sim.landmark_sensor import LandmarkConfiguration
from hslam_sim.simulation import SimulationConfiguration
from hslam_sim.worlds import load_world
from hslam_types.config import Configuration, parameter
from hslam_types.sensing import OdometrySample
from scout_driver.clock import WallClock
from scout_driver.emulator.answers import Answers
from scout_driver.emulator.base import EmulatedBase
from scout_driver.emulator.config import EmulatorConfig, FaultConfig
from scout_driver.emulator.faults import Faults
from scout_driver.emulator.line import EmulatedLine
from scout_driver.emulator.ports import open_port
from scout_driver.emulator.server import EmulatorServer
from scout_driver.emulator.simulated_floor import SimulatedFloor

NS_PER_MS = 1_000_000
CYCLE_GAP_MS = 30
"""A state after so long a pause begins a cycle of the driver, which publishes it; looks go with these alone."""
LOCKSTEP_TICK_MS = 30
"""In lock-step only whole steps are looked at; the tick is that of the direct simulation."""
LOCKSTEP_NODES = ["gvg", "ekf", "atlas"]
FAULT_STREAM = 4
"""Stream of chance of the faults, after the four of the simulation."""


@dataclass(frozen=True)
class RunConfiguration(Configuration):
    """Which world, where the line comes out, and how time passes."""

    world: str = parameter("small_world", "name of a shipped world, or path of a world's or map_server's YAML file")
    seed: int = parameter(0, "seed of every chance of the run", low=0, high=2**31 - 1)
    landmark_seed: int = parameter(0, "seed of the landmarks' places on the walls", low=0, high=2**31 - 1)
    port: str = parameter("", "link to make to the pseudo-terminal (none: its own name is logged), or tcp://host:port")
    real_time_factor: float = parameter(1.0, "emulated by wall time; tell the driver the same", low=0.01, high=100.0)
    lockstep: bool = parameter(False, "each exchange is one step of the world, taken once the last is answered")
    step_s: float = parameter(0.12, "lock-step: how far an exchange moves the world", low=0.01, high=1.0, unit="s")
    warn_after_s: float = parameter(5.0, "wall time until a missing answer is reported", low=0.1, high=3600.0, unit="s")
    fail_after_s: float = parameter(10.0, "wall time until it ends the run", low=0.1, high=3600.0, unit="s")
    start_within_s: float = parameter(
        60.0, "wall time the nodes may take to answer the first", low=0.1, high=3600.0, unit="s"
    )


class EmulatorNode(Node):
    """Serves the line, and publishes landmarks, the truth and the clock at the board times the driver stamps with."""

    def __init__(self) -> None:
        """Load the world and open the line; raises HslamError."""
        super().__init__("scout_emulator")
        self._run = declare(self, RunConfiguration)
        config, faults = declare(self, EmulatorConfig, "base."), declare(self, FaultConfig, "faults.")
        landmarks = declare(self, LandmarkConfiguration, "landmarks.")
        if self._run.lockstep:
            config = dataclasses.replace(config, exchange_s=self._run.step_s, tick_ms=LOCKSTEP_TICK_MS)
        world = load_world(self._run.world, landmark_seed=self._run.landmark_seed)
        simulated = SimulationConfiguration(landmarks=landmarks)
        self._floor = SimulatedFloor(world, config.tick_ms * 1e-3, self._run.seed, simulated)
        self._base = EmulatedBase(self._floor, config)
        rng = np.random.default_rng([self._run.seed, FAULT_STREAM])
        line = EmulatedLine(self._base, config, Faults(faults, rng))
        self._look_ms = round(config.look_s * 1000)
        self._next_look_ms, self._last_ms, self._looks = self._look_ms, -CYCLE_GAP_MS, 0
        self._finished = False
        self._create_topics()
        port = open_port(self._run.port)
        self._answers = self._listen()
        self._server = EmulatorServer(
            line,
            port,
            WallClock(self._run.real_time_factor),
            self._run.real_time_factor,
            self._on_state,
            self._answers.wait,
        )
        self._server.start()
        self.get_logger().info(f"the emulated Scout's line is {port.address}")

    def close(self) -> None:
        """End the line."""
        self._answers.end()
        self._server.stop()

    def _create_topics(self) -> None:
        self._clock_topic = self.create_publisher(ClockMsg, "/clock", CYCLE)
        self._landmarks = self.create_publisher(LandmarkObservations, "landmarks", CYCLE)
        self._status = self.create_publisher(NodeStatus, "~/status", CYCLE)
        self._truth = self.create_publisher(Odometry, "ground_truth", CYCLE)
        self._finish_service = self.create_service(Trigger, "~/finish", self._on_finish)

    def _listen(self) -> Answers:
        about = ParameterDescriptor(description="nodes whose status must answer each lock-step", read_only=True)
        names = [name for name in self.declare_parameter("lockstep_nodes", LOCKSTEP_NODES, about).value if name]
        run = self._run
        waited = names if run.lockstep else []
        answers = Answers(waited, run.warn_after_s, run.fail_after_s, run.start_within_s)
        self._statuses = [
            self.create_subscription(
                NodeStatus,
                f"{name}/status",
                functools.partial(self._on_status, answers, name),
                CYCLE,
            )
            for name in names
        ]
        return answers

    def _on_status(self, answers: Answers, name: str, msg: NodeStatus) -> None:
        answers.answer(name, stamp_from_msg(msg.header.stamp), mission_complete=msg.finished)

    def _on_state(self, board_ms: int) -> None:
        """Publish what belongs to a state before the state itself leaves (called by the serving thread)."""
        stamp_ns = board_ms * NS_PER_MS
        self._answers.expect(stamp_ns)
        self._clock_topic.publish(ClockMsg(clock=stamp_to_msg(stamp_ns)))
        self._truth.publish(odometry_to_msg(OdometrySample(stamp_ns, self._floor.true_pose), parent="map"))
        begins_cycle = board_ms - self._last_ms >= CYCLE_GAP_MS
        self._last_ms = board_ms
        if begins_cycle and board_ms >= self._next_look_ms:
            self._next_look_ms += self._look_ms * ((board_ms - self._next_look_ms) // self._look_ms + 1)
            self._looks += 1
            self._landmarks.publish(landmarks_to_msg(self._floor.look(stamp_ns)))
        about = header(stamp_ns, "")
        self._status.publish(NodeStatus(header=about, node=self.get_name(), outputs=self._looks, state="serving"))

    def over(self) -> bool:
        """Return whether the run has ended; raises LockStepError when a node has kept it waiting too long."""
        if self._server.failure is not None:
            raise self._server.failure
        if late := self._answers.late():
            self.get_logger().warning(f"waiting for {', '.join(late)} at {self._base.now_s:.2f} s")
        return self._finished or self._answers.mission_complete

    def _on_finish(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._finished = True
        response.success = True
        response.message = f"ended at {self._base.now_s:.2f} s, {self._floor.collisions} contacts"
        return response


def main() -> None:
    """Run until a status says that the mission is complete, the `finish` service is called, or a signal."""
    run(EmulatorNode, done=lambda node: isinstance(node, EmulatorNode) and node.over())


if __name__ == "__main__":
    main()
