"""The Scout as a lifecycle node: the topics of the simulated base, from a serial line.

Activating opens the line and begins to obey commands, deactivating stops the base, cleaning up lets the
line go.  One thread: the line is spoken to from a timer (running free) or from the command
that answers the last reading (lock-step, with an emulator that waits as well).
"""

import dataclasses

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from hslam_msgs.msg import SonarRing
from nav_msgs.msg import Odometry
from rclpy.clock import Clock as RosClock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.timer import Timer
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from hslam_ros import conversions
from hslam_ros.door import Door, stamped
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE, LATCHED
from hslam_ros.spin import run
from hslam_ros.stamps import NS_PER_S
from hslam_ros.transforms import transform_to_msg
from hslam_types.sensing import SonarPing, Velocity
from scout_driver import scout_messages
from scout_driver.clock import BoardTime, WallClock
from scout_driver.config import DriverConfig, NodeConfig
from scout_driver.driver import Reading, ScoutDriver
from scout_driver.reading_stamps import ReadingStamps
from scout_driver.transport import PatientTransport, Transport, open_transport

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Commands: the newest alone counts, and one from before this node began must never reach it."""


class ScoutNode(LifecycleNode):
    """One base."""

    def __init__(self) -> None:
        """Declare everything; nothing is opened yet. Raises HslamError on a bad parameter."""
        super().__init__("scout")
        self._config, self._scout = declare(self, NodeConfig), declare(self, DriverConfig)
        if self._config.lockstep:  # a slow machine must not look like a lost reply
            self._scout = dataclasses.replace(self._scout, reply_timeout_s=60.0, gap_timeout_s=10.0)
        self._driver: ScoutDriver | None = None
        self._last: Reading | None = None
        self._pings: list[tuple[float, SonarPing]] = []
        self._stamps = ReadingStamps(board=self._config.board_stamps or self._config.lockstep)
        self._steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self._timers: list[Timer] = []
        self._create_topics()
        if self._config.autostart:
            self.trigger_configure()
            self.trigger_activate()

    def _create_topics(self) -> None:
        self._odom = self.create_publisher(Odometry, "odom", CYCLE)
        self._sonar = self.create_publisher(SonarRing, "sonar", CYCLE)
        self._tf = self.create_publisher(TFMessage, "/tf", 100)
        self._bumper = self.create_publisher(Bool, "bumper", LATCHED)
        self._battery = self.create_publisher(BatteryState, "battery", LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        profile = CYCLE if self._config.lockstep else NEWEST
        self._door = Door(self)
        command = stamped(conversions.velocity_from_msg)
        self._door.hear(TwistStamped, "cmd_vel", command, self._on_command, profile, self._on_refused_command)
        self._zero = self.create_service(Trigger, "~/zero_odometry", self._on_zero)
        self._limp = self.create_service(SetBool, "~/limp", self._on_limp)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        factor = self._config.time_factor
        board = BoardTime() if self._config.lockstep else None
        self._driver = ScoutDriver(self._scout, board or WallClock(factor), self._open, board)
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        if self._driver is not None:
            self._driver.enable()
        period_s = 0.25 if self._config.lockstep else self._scout.cycle_s / self._config.time_factor
        self._timers = [
            self.create_timer(period_s, self._on_cycle, clock=self._steady),
            self.create_timer(1.0, self._report, clock=self._steady),
        ]
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        for timer in self._timers:
            self.destroy_timer(timer)
        self._timers = []
        if self._driver is not None and not self._driver.disable():
            self.get_logger().error("the base did not confirm its stop; its watchdog will stop it")
        return super().on_deactivate(state)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        self.close()
        return TransitionCallbackReturn.SUCCESS

    on_shutdown = on_cleanup

    def close(self) -> None:
        """Stop the base and let the line go; in lock-step time stands still, and so does the base."""
        if self._driver is not None:
            self._driver.close(stop=not self._config.lockstep)
            self._driver = None

    def _open(self) -> Transport:
        transport = open_transport(self._scout.port, self._scout.baud, self._config.time_factor)
        return PatientTransport(transport, self.context.ok) if self._config.lockstep else transport

    def _on_cycle(self) -> None:
        """Exchange by the timer; in lock-step only until the first reading, from then on commands do."""
        driver = self._driver
        if driver is None or not self._timers:  # a tick that was due when deactivation took the timers away
            return
        if self._config.lockstep and self._last is not None:
            return
        if not self._config.lockstep:
            next_s = driver.sonar.next_cycle_s(driver.now(), self._scout.cycle_s)
            self._timers[0].timer_period_ns = round(next_s / self._config.time_factor * NS_PER_S)
        self._exchange(publish=True)

    def _on_refused_command(self, stamp_ns: int | None) -> None:
        """Stop the base: who commands what is no number has lost it."""
        if stamp_ns is not None:
            self._on_command((stamp_ns, Velocity()))

    def _on_command(self, said: tuple[int, Velocity]) -> None:
        driver, (stamp_ns, velocity) = self._driver, said
        if driver is None or (not self._config.lockstep and self._stale(stamp_ns)):
            return
        driver.command(velocity)
        if not self._config.lockstep:
            self._exchange(publish=False)  # the wheels hear of it now; the next cycle publishes what was heard
        elif self._last is not None and stamp_ns >= self._stamps.stamp_ns(self._last):
            self._exchange(publish=True)

    def _stale(self, stamp_ns: int) -> bool:
        """Tell whether a command is too old to be obeyed; an unstamped one (0) counts as new."""
        if self._config.board_stamps or stamp_ns == 0:
            return False
        age_ns = self.get_clock().now().nanoseconds - stamp_ns
        return bool(age_ns > self._scout.command_timeout_s * NS_PER_S)

    def _exchange(self, *, publish: bool) -> None:
        driver = self._driver
        reading = driver.cycle() if driver is not None else None
        if reading is None or driver is None:
            return
        self._stamps.anchor(self.get_clock().now().nanoseconds, driver.now())
        self._pings += reading.pings
        if publish:
            self._publish(reading)

    def _publish(self, reading: Reading) -> None:
        """Publish a reading; odometry goes last, so that its cycle's readings are mostly there when it comes."""
        before, self._last = self._last, reading
        sweep = self._stamps.sweep(reading, self._pings)
        self._pings = []
        odom = self._stamps.odometry(reading)
        self._tf.publish(transform_to_msg(odom.stamp_ns, "odom", "base_link", odom.base_in_odom))
        pressed = bool(reading.state.bumper & self._scout.bumper_mask)
        if before is None or pressed != bool(before.state.bumper & self._scout.bumper_mask):
            self._bumper.publish(Bool(data=pressed))
        self._sonar.publish(conversions.sonar_to_msg(sweep))
        self._odom.publish(conversions.odometry_to_msg(odom))

    def _report(self) -> None:
        """Publish battery and diagnostics, once a second."""
        if self._driver is None:
            return
        last = self._last
        stamp_ns = self._stamps.stamp_ns(last) if last is not None else self.get_clock().now().nanoseconds
        if last is not None:
            self._battery.publish(scout_messages.battery_to_msg(stamp_ns, last.state))
        state = last.state if last is not None else None
        self._diagnostics.publish(scout_messages.diagnostics_to_msg(stamp_ns, self._driver, state, self._door.refused))

    def _on_zero(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._driver is not None
        response.message = "the origin of odom is here now" if self._driver else "not configured"
        if self._driver is not None:
            self._driver.odometry.zero()
        return response

    def _on_limp(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = self._driver is not None
        response.message = ("motors off" if request.data else "motors hold") if self._driver else "not configured"
        if self._driver is not None:
            self._driver.set_limp(limp=bool(request.data))
        return response


def main() -> None:
    """Run the node until a signal; the base is stopped on the way out."""
    run(ScoutNode)


if __name__ == "__main__":
    main()
