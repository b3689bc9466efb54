"""A base that does as it is told, with an exact scanner among drawn walls and the level that drives it, for tests."""

import dataclasses
import math

import pytest
from drawn_scans import scan_of
from drawn_walls import CROSSING, Wall

from hslam_gvg.follow_config import FollowConfig
from hslam_gvg.graph_follower import GraphFollower
from hslam_gvg.states import GvgState
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeView
from hslam_types.se2 import SE2
from hslam_types.sensing import OdometrySample, Velocity

STEP_S = 0.12
ENDS: tuple[Wall, ...] = ((8, -1.2, 8, 1.2), (-8, -1.2, -8, 1.2), (-1.2, 8, 1.2, 8), (-1.2, -8, 1.2, -8))
CLOSED = CROSSING + ENDS
START = SE2(-3.0, 0.2, 0.1)
ACCESS, STOP = GvgGoal(GoalKind.ACCESS), GvgGoal(GoalKind.STOP)


class Robot:
    """A perfect base among walls, with the level that drives it."""

    def __init__(
        self,
        walls: tuple[Wall, ...] = CLOSED,
        start: SE2 = START,
        config: FollowConfig | None = None,
    ) -> None:
        self.walls, self.pose, self.stamp_ns = walls, start, 0
        self.level, self.command = GraphFollower(config), Velocity()
        self.events: list[GvgEvent] = []
        self.room_m = math.inf
        self.state = GvgState.IDLE
        self.dropped: list[str] = []
        self.slipping = False

    def step(self, *, blind: bool = False) -> None:
        """Drive one step under the last command, and let the level answer what is seen from there."""
        self.stamp_ns += round(STEP_S * 1e9)
        if not self.slipping:
            for _ in range(4):
                self.pose = self.pose @ SE2(
                    0.25 * STEP_S * self.command.forward, 0.0, 0.25 * STEP_S * self.command.turn
                )
        scan = dataclasses.replace(scan_of(self.walls, self.pose), stamp_ns=self.stamp_ns)
        self.room_m = min(self.room_m, float(scan.ranges.min()))
        out = self.level.step(OdometrySample(self.stamp_ns, self.pose, self.command), None if blind else scan)
        self.command, self.state = out.command, out.state
        self.events += out.events
        self.dropped += [out.dropped] if out.dropped else []

    def until(self, kind: EventKind, within_s: float = 120.0) -> GvgEvent:
        """Drive until an event of a kind comes; fails when it does not."""
        seen = len(self.events)
        for _ in range(round(within_s / STEP_S)):
            self.step()
            for event in self.events[seen:]:
                if event.kind is kind:
                    return event
        pytest.fail(f"no {kind.name} in {within_s} s; {[e.kind.name for e in self.events]}, {self.state}, {self.pose}")

    def go(self, goal: GvgGoal) -> None:
        """Give a goal at once."""
        self.level.start(goal)

    def arrived(self) -> NodeView:
        """Reach the GVG and follow it to its first node."""
        self.step()
        self.go(ACCESS)
        self.until(EventKind.ACCESS)
        node = self.until(EventKind.ARRIVAL).node
        assert node is not None
        return node
