"""The GVG level in the hard simulator: every node with its degree, none invented, no wall touched."""

import math
from dataclasses import dataclass

import pytest
from hash_seeds import under_two_hash_seeds

from hslam_gvg.server import GvgServer
from hslam_sim.simulation import SimStep, Simulation
from hslam_sim.worlds import load_world
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

NODES = {(9.0, 0.0): 3, (0.0, 4.0): 3, (9.0, -6.0): 1, (-5.5, 4.0): 1}
"""The reduced GVG of small_world: places (m, map) and degrees."""
GATE_M = 1.0
STEPS = 3500


@dataclass(frozen=True)
class Visit:
    """One announcement of a node, with the truth of its moment."""

    event: GvgEvent
    step: SimStep
    turned: float
    """Heading of odom in map (rad)."""

    def place(self) -> tuple[float, float]:
        """Return where the node announced truly is (m, map)."""
        assert self.event.node is not None
        odom_in_map = self.step.truth @ self.step.odom.base_in_odom.inverse()
        return odom_in_map.apply(self.event.node.x_in_odom, self.event.node.y_in_odom)


def wander(seed: int) -> tuple[list[Visit], list[Visit], int, list[GvgEvent]]:
    """Drive from node to node, each time the next branch; return arrivals, departures, contacts and all events."""
    simulation, server = Simulation(load_world("small_world"), seed=seed), GvgServer()
    server.start(GvgGoal(GoalKind.ACCESS))
    command, arrivals, departures, events = Velocity(), list[Visit](), list[Visit](), list[GvgEvent]()
    step = simulation.step(command)
    for _ in range(STEPS):
        out = server.step(step.odom, step.sonar)
        for event in out.events:
            events.append(event)
            visit = Visit(event, step, wrap(step.truth.theta - step.odom.base_in_odom.theta))
            if event.kind == EventKind.ARRIVAL and event.node is not None:
                arrivals.append(visit)
                server.start(GvgGoal(GoalKind.TRACE, (event.branch + 1) % event.node.degree))
            elif event.kind == EventKind.DEPARTURE:
                departures.append(visit)
        step = simulation.step(out.command)
    return arrivals, departures, step.collisions, events


@pytest.mark.parametrize("seed", [1, 2])
def test_a_wandering_robot_names_every_node_it_passes_and_no_other(seed: int) -> None:
    arrivals, departures, contacts, events = wander(seed)
    assert contacts == 0
    assert [event.sequence for event in events] == list(range(len(events)))
    assert not [event for event in events if event.kind == EventKind.LOST]
    assert len(arrivals) >= 5
    for visit in arrivals:
        assert visit.event.node is not None
        x, y = visit.place()
        nearest = min(NODES, key=lambda node: math.dist(node, (x, y)))
        assert math.dist(nearest, (x, y)) < GATE_M
        assert visit.event.node.degree == NODES[nearest]
        # The robot stands at the node it announces.
        pose = visit.step.odom.base_in_odom
        assert math.hypot(visit.event.node.x_in_odom - pose.x, visit.event.node.y_in_odom - pose.y) < 0.15
    for visit in departures:
        assert visit.event.node is not None
        bearing = visit.event.node.bearings_in_odom[visit.event.branch]
        assert abs(wrap(bearing - visit.step.odom.base_in_odom.theta)) < math.radians(5.0)


def steps_of_a_seed() -> str:
    """Return what the GVG level says in the first steps of a run."""
    simulation, server = Simulation(load_world("small_world"), seed=3), GvgServer()
    server.start(GvgGoal(GoalKind.ACCESS))
    command, said = Velocity(), list[str]()
    for _ in range(400):
        step = simulation.step(command)
        out = server.step(step.odom, step.sonar)
        command = out.command
        said.append(repr(out))
    return "\n".join(said)


def test_a_seed_gives_the_same_events_bit_for_bit() -> None:
    first, second = under_two_hash_seeds(steps_of_a_seed)
    assert first == second
    assert "ACCESS" in first
