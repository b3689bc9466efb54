"""Replay as a node: publishes a bag with /clock, at a rate, or in lock-step as fast as live nodes answer."""

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from hslam_msgs.msg import NodeStatus
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMsg
from std_srvs.srv import Trigger

from hslam_bags.answers import Answers
from hslam_bags.bag import Bag
from hslam_bags.cycles import replayed
from hslam_bags.errors import BagError
from hslam_bags.pace import Pace
from hslam_bags.promises import COUNTED, Promises
from hslam_bags.replay_configuration import ReplayConfiguration
from hslam_bags.replay_topics import ReplayTopics
from hslam_bags.topic_choice import TopicChoice, names
from hslam_ros.conversions import header
from hslam_ros.parameters import declare
from hslam_ros.qos import CYCLE
from hslam_ros.spin import run
from hslam_ros.stamps import NS_PER_S, stamp_from_msg, stamp_to_msg
from hslam_types.errors import ConfigurationError, HslamError

_TICK_S = 0.005
_CLOCK_EVERY_NS = 25_000_000
"""Wall time between two messages on /clock when replaying at a rate (40 Hz, as `ros2 bag play` does)."""


class ReplayNode(Node):
    """Owns the bag, its publishers and the passing of its time."""

    def __init__(self) -> None:
        """Open the bag; raises HslamError on a bad parameter, a damaged bag or a type that is not installed."""
        super().__init__("replay")
        self._config = declare(self, ReplayConfiguration)
        if not self._config.path:
            raise ConfigurationError("parameter 'path' must name a bag")
        self._live = names(self._config.live)
        if self._config.lockstep and not self._live:
            raise ConfigurationError("lock-step waits for the answers of the nodes in 'live', which is empty")
        self._bag = Bag(Path(self._config.path))
        # At a rate, the recorded statuses are replayed like any other message.
        self._promises = Promises(self._live) if self._config.lockstep else Promises(COUNTED)
        # What live nodes say now, and what this node says itself, is left out.
        own = ("/clock", *sorted(self._promises.status_topics), *(f"/{name}/.*" for name in self._live))
        choice = TopicChoice(names(self._config.topics), (*names(self._config.exclude), *own), hidden=True)
        counts = self._bag.counts
        topics = {name: topic for name, topic in self._bag.topics.items() if name in choice and counts[name]}
        self._topics = ReplayTopics(self, self._bag.path, topics, keep_for_late=self._config.lockstep)
        self._clock_topic = self.create_publisher(ClockMsg, "/clock", CYCLE)
        self._statuses = {
            source: self.create_publisher(NodeStatus, f"/{source}/status", CYCLE) for source in self._promises.sources
        }
        first_ns = (self._bag.span_ns or (0, 0))[0]
        start_ns = first_ns + round(self._config.start_s * NS_PER_S)
        cycle_topic = self.resolve_topic_name(self._config.cycle_topic) if self._config.lockstep else None
        stamped = {name for name in topics if self._topics.is_stamped(name)}
        self._portions = replayed(self._bag, choice, start_ns, stamped, cycle_topic)
        self._next = next(self._portions, None)
        if self._next is None:
            raise BagError(self._bag.path, "", "holds no message to replay after the start that was chosen")
        self._pace = Pace(start_ns, self._config.rate)
        self._answers = Answers(self._live, self._config.start_within_s, self._config.fail_after_s)
        self._resting = self._config.paused
        self._start_wall_ns = time.monotonic_ns() + round(self._config.delay_s * NS_PER_S)
        self._next_clock_ns = 0
        self.published = 0
        self.finished = False
        self.failure: HslamError | None = None
        self._create_controls()

    def _create_controls(self) -> None:
        for name in self._live:
            self.create_subscription(NodeStatus, f"{name}/status", partial(self._on_status, name), CYCLE)
        tick = self._check_answers if self._config.lockstep else self._tick
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        period_s = 0.05 if self._config.lockstep else _TICK_S
        self._timer = self.create_timer(period_s, partial(self._try, tick), clock=steady)
        for name, action in (("pause", self._pause), ("resume", self._resume), ("step", self._step)):
            self.create_service(Trigger, f"~/{name}", partial(self._on_control, action))

    def _on_status(self, name: str, msg: NodeStatus) -> None:
        self._answers.take(name, stamp_from_msg(msg.header.stamp))
        self._try(self._advance)

    def _on_control(
        self, action: Callable[[], None], _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        self._try(action)
        at_s = self._pace.bag_ns(time.monotonic_ns()) / NS_PER_S
        response.success, response.message = True, f"{'at rest' if self._resting else 'running'} at {at_s:.3f} s"
        return response

    def _pause(self) -> None:
        self._resting = True
        self._pace.rest(time.monotonic_ns())

    def _resume(self) -> None:
        self._resting = False

    def _step(self) -> None:
        """Publish the next cycle, or the messages of the next time, and rest."""
        self._pause()
        if not self._answers.missing():
            self._publish_next()

    def _check_answers(self) -> None:
        """Lock-step: fail when an answer is late; begin, or go on after a rest."""
        self._answers.check(time.monotonic())
        self._advance()

    def _advance(self) -> None:
        """Lock-step: publish the next cycle if every live node has answered the one before."""
        if self._config.lockstep and not self._resting and not self.finished and not self._answers.missing():
            self._publish_next()

    def _tick(self) -> None:
        """At a rate: publish what is due."""
        now_ns = time.monotonic_ns()
        if self._resting or now_ns < self._start_wall_ns:
            return
        self._pace.run(now_ns)
        bag_ns = self._pace.bag_ns(now_ns)
        while self._next is not None and self._next.time_ns <= bag_ns:
            self._publish_next()
        if self._next is not None and self._next.time_ns - bag_ns > self._config.max_gap_s * NS_PER_S:
            gap_s = (self._next.time_ns - bag_ns) / NS_PER_S
            self.get_logger().warning(f"passing over {gap_s:.0f} s without a message (parameter max_gap_s)")
            self._pace.jump(self._next.time_ns, now_ns)
        if now_ns >= self._next_clock_ns:
            # After what was due before it: the clock never goes back.
            self._next_clock_ns = now_ns + _CLOCK_EVERY_NS
            self._clock_topic.publish(ClockMsg(clock=stamp_to_msg(bag_ns)))
        self.finished = self._next is None

    def _publish_next(self) -> None:
        """Publish the next portion; the live nodes owe an answer to a complete one."""
        portion = self._next
        if portion is None:
            self.finished = True
            return
        self._next = next(self._portions, None)
        self._clock_topic.publish(ClockMsg(clock=stamp_to_msg(portion.time_ns)))
        for message in portion.messages:
            self._topics.publish(message)
            self._promises.count(message.topic)
        self.published += len(portion.messages)
        if self._config.lockstep or self._resting:
            self._pace.jump(portion.time_ns, time.monotonic_ns())
        for source, status in self._statuses.items() if portion.complete else ():
            about = header(portion.time_ns, "")
            status.publish(
                NodeStatus(header=about, node=source, outputs=self._promises.outputs(source), state="replayed")
            )
        if portion.complete:
            self._answers.expect(portion.time_ns, time.monotonic())

    def close(self) -> None:
        """Let the last messages arrive, and close the bag."""
        if self.finished:
            self._topics.wait_until_heard()
        if self.failure is not None:
            sys.stderr.write(f"{self.get_name()}: {self.failure}\n")
        self._bag.close()

    def _try(self, action: Callable[[], None]) -> None:
        """Do something; a failure is kept and ends the node (executors would shout it)."""
        if self.failure is None:
            try:
                action()
            except HslamError as error:
                self.failure = error


def main() -> None:
    """Run the node to the end of the bag, or until Ctrl-C or SIGTERM; exits 1 with one line on a failure."""
    nodes: list[ReplayNode] = []

    def make() -> ReplayNode:
        nodes.append(ReplayNode())
        return nodes[0]

    try:
        run(make, done=lambda _: nodes[0].finished or nodes[0].failure is not None)
    finally:
        if nodes and nodes[0].failure is not None:
            sys.exit(1)
