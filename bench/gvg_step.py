"""What one step of the GVG level costs: `python bench/gvg_step.py [--world NAME] [--steps N]`.

Wanders from node to node in the simulator. CPU time of this process is counted, which a busy machine does not inflate.
"""

import argparse
import time

from hslam_gvg.server import GvgServer
from hslam_sim.simulation import Simulation
from hslam_sim.worlds import load_world
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.sensing import Velocity


def next_goal(event: GvgEvent) -> GvgGoal | None:
    """Return the goal that follows an event: the next branch round the node, or access."""
    if event.kind == EventKind.ARRIVAL and event.node is not None:
        return GvgGoal(GoalKind.TRACE, (event.branch + 1) % event.node.degree)
    return GvgGoal(GoalKind.ACCESS) if event.kind == EventKind.LOST else None


def main() -> None:
    """Drive and print one line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--world", default="small_world")
    parser.add_argument("--steps", type=int, default=4000)
    options = parser.parse_args()
    simulation, server = Simulation(load_world(options.world), seed=1), GvgServer()
    server.start(GvgGoal(GoalKind.ACCESS))
    command, spent, arrivals = Velocity(), 0.0, 0
    for _ in range(options.steps):
        step = simulation.step(command)
        began = time.process_time()
        out = server.step(step.odom, step.sonar)
        spent += time.process_time() - began
        command = out.command
        for goal in filter(None, map(next_goal, out.events)):
            server.start(goal)
        arrivals += sum(event.kind == EventKind.ARRIVAL for event in out.events)
    print(f"{options.world}: {1e3 * spent / options.steps:.3f} ms a step, {arrivals} arrivals in {options.steps} steps")


if __name__ == "__main__":
    main()
