"""Things no sonar hears: the robot goes slowly where it has not listened, and does not push on when it is held."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from drawn_walls import DEAD_END, HALF, T_JUNCTION, Wall, ideal_range, points_of

from hslam_gvg.accessing import FIRST_SWEEP_S, OPEN_S
from hslam_gvg.caution import BESIDE_WALLS, ONE, SEVERAL, Caution
from hslam_gvg.config import GvgConfig
from hslam_gvg.departing import Departing
from hslam_gvg.homing import Homing
from hslam_gvg.obstacle_map import ObstacleMap
from hslam_gvg.recovery import TRIES, Recovery
from hslam_gvg.server import GvgServer, GvgState
from hslam_gvg.situation import STUCK_S, Situation
from hslam_gvg.stall import STALL_S, StallWatch
from hslam_gvg.trail import Trail
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, OdometrySample, SonarPing, SonarSweep, Velocity

STEP_S = 0.12
STEP_NS = 120_000_000
FIRING_ORDER = (0, 2, 15, 1, 14, 3, 13, 4, 12, 5, 11, 6, 10, 7, 9, 8)
BODY_M = 0.19
Post = tuple[float, float, float]


@dataclass
class Floor:
    """Walls that answer, a round post (x, y, radius, m) that never does, and a base that is held by it."""

    walls: tuple[Wall, ...]
    post: Post
    pose: SE2
    steps: int = 0
    held: int = 0
    """Steps spent pushing against the post."""

    def step(self, command: Velocity, rng: np.random.Generator) -> tuple[OdometrySample, SonarSweep]:
        """Move for one step, held or not, and fire two pings."""
        heading = self.pose.theta + 0.5 * command.turn * STEP_S
        x = self.pose.x + command.forward * STEP_S * math.cos(heading)
        y = self.pose.y + command.forward * STEP_S * math.sin(heading)
        px, py, radius = self.post
        now, before = math.hypot(x - px, y - py), math.hypot(self.pose.x - px, self.pose.y - py)
        if now < BODY_M + radius and now < before:
            self.held += 1
            x, y = self.pose.x, self.pose.y
        self.pose = SE2(x, y, self.pose.theta + command.turn * STEP_S)
        self.steps += 1
        stamp_ns, pings = self.steps * STEP_NS, []
        for i in (0, 1):
            sensor = FIRING_ORDER[(2 * self.steps + i) % 16]
            heard = ideal_range(self.walls, self.pose, sensor) * (1.0 + 0.005 * float(rng.standard_normal()))
            pings.append(SonarPing(sensor, stamp_ns, heard if heard < SCOUT_RING.range_max_m else math.inf))
        return OdometrySample(stamp_ns, self.pose), SonarSweep(stamp_ns, SCOUT_RING, tuple(pings))


def drive(floor: Floor, steps: int, seed: int) -> tuple[GvgServer, list[GvgEvent]]:
    """Access the GVG and follow it until an event ends that."""
    server, rng, events, command = GvgServer(), np.random.default_rng(seed), list[GvgEvent](), Velocity()
    server.start(GvgGoal(GoalKind.ACCESS))
    for _ in range(steps):
        out = server.step(*floor.step(command, rng))
        command = out.command
        events += out.events
        if any(e.kind in (EventKind.ARRIVAL, EventKind.LOST) for e in out.events):
            break
    return server, events


@pytest.mark.parametrize("seed", range(4))
def test_a_silent_post_in_a_corridor_is_felt_remembered_and_left_alone(seed: int) -> None:
    floor = Floor(DEAD_END, (-2.0, 0.05, 0.5), SE2(-6.0, 0.0, 0.0))
    server, events = drive(floor, 1200, seed)
    assert floor.held, "the post was never met: the test says nothing"
    # It tries no more than a few times, and pushes for no longer than it takes to notice.
    assert floor.held <= 5 * (STALL_S / STEP_S + 2)
    assert events[-1].kind in (EventKind.ARRIVAL, EventKind.LOST)
    assert math.hypot(floor.pose.x + 2.0, floor.pose.y - 0.05) > BODY_M + 0.5 + 0.05
    points = server.map.points()
    off = np.hypot(points[:, 0] + 2.0, points[:, 1] - 0.05)
    assert (np.abs(off - 0.5) < 0.15).sum() >= 2


def test_where_the_way_is_shut_for_good_the_edge_ends() -> None:
    floor = Floor(DEAD_END, (-1.0, 0.0, 1.1), SE2(-6.0, 0.0, 0.0))
    _, events = drive(floor, 2000, 1)
    assert floor.held
    end = events[-1]
    assert end.kind is EventKind.ARRIVAL
    assert end.node is not None
    assert end.node.kind is NodeKind.BOUNDARY_POINT
    assert end.node.x_in_odom < -2.0


def test_a_straight_drive_into_something_silent_is_given_up() -> None:
    floor = Floor(T_JUNCTION, (-4.0, 0.0, 0.1), SE2(-6.0, 0.0, 0.0))
    server, rng, command = GvgServer(), np.random.default_rng(1), Velocity()
    server.start(GvgGoal(GoalKind.STRAIGHT, x_in_odom=-2.0, y_in_odom=0.0))
    kinds = []
    for _ in range(400):
        out = server.step(*floor.step(command, rng))
        command = out.command
        kinds += [event.kind for event in out.events]
    assert kinds == [EventKind.LOST]
    assert 0 < floor.held <= STALL_S / STEP_S + 2


@pytest.mark.parametrize("kind", [GoalKind.STOP, GoalKind.ACCESS])
@pytest.mark.parametrize("held_for", range(1, math.ceil(STALL_S / STEP_S) + 1))
def test_a_goal_begun_while_the_body_is_held_stands_still_all_the_same(kind: GoalKind, held_for: int) -> None:
    floor = Floor(T_JUNCTION, (-4.0, 0.0, 0.1), SE2(-6.0, 0.0, 0.0))
    server, rng, command = GvgServer(), np.random.default_rng(1), Velocity()
    server.start(GvgGoal(GoalKind.STRAIGHT, x_in_odom=-2.0, y_in_odom=0.0))
    while floor.held < held_for:
        command = server.step(*floor.step(command, rng)).command
    server.start(GvgGoal(kind))
    for _ in range(math.ceil(FIRST_SWEEP_S / STEP_S) - 1):
        out = server.step(*floor.step(command, rng))
        command = out.command
        assert out.state is (GvgState.IDLE if kind is GoalKind.STOP else GvgState.LISTENING)
        assert command == Velocity()


def test_a_base_that_does_not_come_round_is_lost() -> None:
    now = Situation(GvgConfig())
    departing = Departing(now)
    now.heading = 1.0
    now.enter(GvgState.RESUMING)
    assert departing.resume().turn > 0.0
    now.stamp_ns += round(11.0 * STUCK_S * 1e9)
    assert departing.resume() == Velocity()
    assert [event.kind for event in now.announcements.tell(now.stamp_ns)] == [EventKind.LOST]
    assert now.state is GvgState.IDLE


def test_an_access_that_is_held_again_and_again_is_given_up() -> None:
    now = Situation(GvgConfig())
    recovery = Recovery(now, Homing(now))
    now.begin(OdometrySample(STEP_NS, SE2()))
    now.enter(GvgState.ACCESSING)
    for _ in range(TRIES):
        recovery.held(1.0)
        recovery.held(-1.0)
        assert now.state is GvgState.ACCESSING
    recovery.held(1.0)
    recovery.held(-1.0)
    assert now.state is GvgState.IDLE
    assert [event.kind for event in now.announcements.tell(now.stamp_ns)] == [EventKind.LOST]


def test_in_the_open_the_gvg_is_taken_for_reached() -> None:
    far = ((-90.0, 90.0, -89.0, 90.0),)
    floor, server, rng, command = (
        Floor(far, (50.0, 50.0, 0.1), SE2()),
        GvgServer(),
        np.random.default_rng(1),
        Velocity(),
    )
    server.start(GvgGoal(GoalKind.ACCESS))
    events = list[GvgEvent]()
    while not events and floor.steps < 2.0 * (FIRST_SWEEP_S + OPEN_S) / STEP_S:
        out = server.step(*floor.step(command, rng))
        command, events = out.command, [*out.events]
    assert [event.kind for event in events] == [EventKind.ACCESS]
    assert floor.pose.x > 0.1, "it should have looked round on the move first"


def watch(commands: list[float], shares: list[float], turn: float = 0.0) -> list[bool]:
    """Return when a stall is seen while the wheels do these shares of what they are told."""
    stall, x, seen = StallWatch(), 0.0, []
    stall.sees(OdometrySample(0, SE2()))
    for i, (told, share) in enumerate(zip(commands, shares, strict=True)):
        stall.tell(Velocity(told, turn))
        x += share * told * STEP_S
        seen.append(stall.sees(OdometrySample((i + 1) * STEP_NS, SE2(x, 0.0, 0.0))))
    return seen


def test_held_wheels_are_a_stall_after_a_while_and_only_then() -> None:
    seen = watch([0.2] * 12, [1.0] * 4 + [0.0] * 8)
    assert seen.index(True) == 4 + math.ceil(STALL_S / STEP_S) - 1
    assert sum(seen) == 1


@pytest.mark.parametrize(
    ("commands", "shares"),
    [
        ([0.4] * 20, [0.0, 0.1, 0.4] + [1.0] * 17),
        ([0.0] * 20, [0.0] * 20),
        ([0.02] * 20, [0.0] * 20),
        ([0.4, 0.4, 0.4, -0.4, -0.4, -0.4] * 3, [0.0] * 18),
    ],
    ids=["slow start", "standing", "slower than encoders tell", "to and fro"],
)
def test_no_stall_without_being_held(commands: list[float], shares: list[float]) -> None:
    assert not any(watch(commands, shares))


def test_a_touch_is_an_obstacle_in_the_way_it_was_met() -> None:
    memory = ObstacleMap(GvgConfig())
    memory.move(SE2(1.0, 0.0, 0.0))
    memory.touch(SE2(1.0, 0.0, 0.0), -1.0)
    points = memory.points()
    assert len(points)
    assert (points[:, 0] < 1.0 - 0.15).all()
    assert np.hypot(points[:, 0] - 1.0, points[:, 1]).min() > BODY_M


def listen(caution: Caution, base: SE2, pings: int) -> None:
    """Let the front sonar fire into silence."""
    sweep = SonarSweep(0, SCOUT_RING, tuple(SonarPing(0, 0, math.inf) for _ in range(pings)))
    caution.hear(sweep, (base,) * pings)


CORRIDOR = points_of(((-8, HALF, 8, HALF), (-8, -HALF, 8, -HALF)))
BEHIND_ONLY = points_of(((-8, HALF, -1, HALF), (-8, -HALF, -1, -HALF)))


def test_full_speed_takes_listening() -> None:
    caution, base, wish = Caution(GvgConfig()), SE2(), Velocity(0.4, 0.1)
    unheard = caution.limit(wish, base, CORRIDOR, Trail(), SEVERAL)
    assert 0.0 < unheard.forward < 0.4
    assert unheard.turn == 0.1
    listen(caution, base, int(BESIDE_WALLS))
    assert caution.limit(wish, base, CORRIDOR, Trail(), SEVERAL) == wish


def test_away_from_all_that_is_known_it_takes_more() -> None:
    caution, base, wish = Caution(GvgConfig()), SE2(), Velocity(0.4, 0.0)
    listen(caution, base, int(BESIDE_WALLS))
    slow = caution.limit(wish, base, BEHIND_ONLY, Trail(), SEVERAL).forward
    assert 0.0 < slow < 0.3
    listen(caution, base, 20)
    assert caution.limit(wish, base, BEHIND_ONLY, Trail(), SEVERAL) == wish


def test_where_the_body_has_been_nothing_slows_it() -> None:
    caution, trail, wish = Caution(GvgConfig()), Trail(), Velocity(-0.4, 0.0)
    for x in np.arange(-1.0, 0.01, 0.05):
        trail.advance(float(x), 0.0)
    assert caution.limit(wish, SE2(), CORRIDOR, trail, SEVERAL) == wish
    assert caution.limit(Velocity(0.4, 0.0), SE2(), CORRIDOR, trail, SEVERAL).forward < 0.4


def test_what_is_known_to_stand_in_the_way_stops_it() -> None:
    caution, post = Caution(GvgConfig()), np.array([[0.22, 0.05]])
    assert caution.limit(Velocity(0.1, 0.3), SE2(), post, Trail(), ONE) == Velocity(0.0, 0.3)
    assert caution.blocked
    assert caution.limit(Velocity(-0.05, 0.0), SE2(), post, Trail(), ONE) == Velocity(-0.05, 0.0)
    assert not caution.blocked


def test_what_may_be_an_echo_in_mid_air_slows_it_only() -> None:
    config = GvgConfig()
    caution, ghost = Caution(config), np.array([[0.22, 0.05]])
    assert caution.limit(Velocity(0.4, 0.3), SE2(), ghost, Trail(), SEVERAL) == Velocity(config.creep_m_s, 0.3)
    assert not caution.blocked
    edge = ghost + np.array([[0.0, 0.0], [0.03, 0.0], [0.05, 0.02]])
    assert caution.limit(Velocity(0.4, 0.3), SE2(), edge, Trail(), SEVERAL) == Velocity(0.0, 0.3)
    assert caution.blocked


def test_the_trail_leads_back() -> None:
    trail = Trail()
    for x in np.arange(0.0, 1.0, 0.02):
        trail.advance(float(x), 0.0)
    x, y = trail.before(1.0, 0.0, 0.3)
    assert 0.6 < x <= 0.7
    assert y == 0.0
    assert trail.has(0.5, 0.1)
    assert not trail.has(0.5, 0.3)
